// The pointer: what it is on is named, and its constraint marked.
import { constraintText, elementText } from "./measurements.js";

/** `shown()` gives the series and the index that the stage shows; `onBond` gets a constraint or null. */
export function namePartsUnder(canvas, tooltip, stage, scene, { shown, onBond }) {
  let pending = null;

  function point(event) {
    pending = event.buttons && event.pointerType === "mouse" ? null : event;
    if (!pending) tooltip.hidden = true;
    else requestAnimationFrame(measure);
  }

  function measure() {
    if (!pending) return;
    const { clientX, clientY } = pending;
    pending = null;
    const part = stage.under(clientX, clientY);
    const isBond = part && part.bond !== undefined;
    onBond(isBond ? part.bond : null);
    const { series, index } = shown();
    const text = isBond
      ? constraintText(scene, series, index, part.bond)
      : part?.element && elementText(scene, part.body, part.element, stage);
    tooltip.hidden = !text;
    if (text) place(text, clientX, clientY);
  }

  function place(text, clientX, clientY) {
    tooltip.textContent = text;
    const home = canvas.getBoundingClientRect();
    const box = tooltip.getBoundingClientRect();
    const x = Math.max(4, Math.min(clientX - home.left + 14, home.width - box.width - 4));
    const isLow = clientY - home.top + 16 + box.height > home.height;
    const y = isLow ? clientY - home.top - box.height - 12 : clientY - home.top + 16;
    tooltip.style.transform = `translate(${x + canvas.offsetLeft}px, ${y + canvas.offsetTop}px)`;
  }

  canvas.addEventListener("pointermove", point);
  canvas.addEventListener("pointerdown", point);
  canvas.addEventListener("pointerleave", () => {
    pending = null;
    tooltip.hidden = true;
    onBond(null);
  });
}
