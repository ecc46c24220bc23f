// Names and numbers: text over the picture, drawn once more when a picture is saved.
import { Vector3 } from "three";

const projected = new Vector3();

export class Labels {
  constructor(home) {
    this.home = home;
    this.entries = [];
    this.visible = true;
  }

  /** `world()` gives the place of the label in the scene, `anchor` how it sits there. */
  add(text, className, world, anchor = "beside") {
    const span = document.createElement("span");
    span.textContent = text;
    span.className = className;
    this.home.append(span);
    const entry = { span, text, world, anchor, x: 0, y: 0, shown: false };
    this.entries.push(entry);
    return entry;
  }

  place(camera, width, height) {
    for (const entry of this.entries) {
      const at = entry.world();
      entry.shown = this.visible && at !== null;
      if (entry.shown) {
        projected.copy(at).project(camera);
        entry.shown = Math.abs(projected.z) < 1;
        entry.x = ((projected.x + 1) / 2) * width;
        entry.y = ((1 - projected.y) / 2) * height;
      }
      const { style } = entry.span;
      style.display = entry.shown ? "" : "none";
      const shift = entry.anchor === "on" ? "translate(-50%, -50%)" : "translate(9px, -16px)";
      if (entry.shown) style.transform = `translate(${entry.x.toFixed(1)}px, ${entry.y.toFixed(1)}px) ${shift}`;
    }
  }

  /** Draw the labels on a canvas on which a pixel of the page is `scale` pixels. */
  draw(context, scale) {
    context.save();
    context.scale(scale, scale);
    context.textBaseline = "middle";
    for (const { span, text, x, y, anchor, shown } of this.entries) {
      if (!shown) continue;
      const style = getComputedStyle(span);
      context.font = `${style.fontStyle} ${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
      const width = context.measureText(text).width;
      const left = anchor === "on" ? x - width / 2 : x + 9;
      const middle = anchor === "on" ? y : y - 10;
      if (anchor === "on") {
        context.fillStyle = style.backgroundColor;
        context.strokeStyle = style.color;
        context.lineWidth = 1;
        context.beginPath();
        context.roundRect(left - 5.5, middle - 9, width + 11, 18, 9);
        context.fill();
        context.stroke();
      }
      context.fillStyle = style.color;
      context.fillText(text, left, middle + 0.5);
    }
    context.restore();
  }
}
