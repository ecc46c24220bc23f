// Names and numbers: text over the picture, drawn once more when a picture is saved.
import { Vector3 } from "three";
import { arrange } from "./places.js";

const projected = new Vector3();

export class Labels {
  constructor(home) {
    this.home = home;
    this.entries = [];
    this.visible = true;
  }

  /** `world()` gives the place of the label in the scene; it stands `beside` it, or `on` it if there is room. */
  add(text, className, world, anchor = "beside") {
    const span = document.createElement("span");
    span.textContent = text;
    span.className = className;
    this.home.append(span);
    const { offsetWidth: width, offsetHeight: height } = span;
    const entry = { span, text, world, anchor, width, height, x: 0, y: 0, step: null, box: null, shown: false };
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
      entry.span.style.display = entry.shown ? "" : "none";
    }
    const shown = this.entries.filter((entry) => entry.shown);
    arrange(shown, width, height);
    for (const { span, box } of shown) span.style.transform = `translate(${box.left.toFixed(1)}px, ${box.top.toFixed(1)}px)`;
  }

  /** Draw the labels on a canvas on which a pixel of the page is `scale` pixels. */
  draw(context, scale) {
    context.save();
    context.scale(scale, scale);
    context.textBaseline = "middle";
    context.textAlign = "center";
    for (const { span, text, box, width, height, anchor, shown } of this.entries) {
      if (!shown) continue;
      const style = getComputedStyle(span);
      context.font = `${style.fontStyle} ${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
      if (anchor === "on") {
        context.fillStyle = style.backgroundColor;
        context.strokeStyle = style.color;
        context.lineWidth = 1;
        context.beginPath();
        context.roundRect(box.left, box.top, width, height, height / 2);
        context.fill();
        context.stroke();
      }
      context.fillStyle = style.color;
      context.fillText(text, box.left + width / 2, box.top + height / 2 + 0.5);
    }
    context.restore();
  }
}
