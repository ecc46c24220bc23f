// The list of all real modes: number, colour, position, condition; a row that goes, fades.
import { reveal } from "../facts.js";
import { short } from "../numbers.js";
import { cueOf } from "./mode_colours.js";

const FADING = 1500;
const DIGITS = 4;
const HEADS = ["mode", "x", "y", "z", "condition"];

export class ModeList {
  /** `homeIndex` is that of the mode of home, or null; `paint(number)` is the colour of a mode, `onMode(number)` follows it. */
  constructor(home, size, homeIndex, { paint, onMode }) {
    Object.assign(this, { paint, onMode, home: homeIndex === null ? null : homeIndex + 1 });
    this.places = Math.max(0, DIGITS - Math.ceil(Math.log10(size)));
    home.innerHTML = `<div class="scroll" tabindex="0"><table id="modes"><thead><tr>${HEADS.map((text) =>
      `<th scope="col"><span data-term="${text}">${text}</span></th>`).join("")}</tr></thead><tbody></tbody></table></div>`;
    this.body = home.querySelector("tbody");
    this.rows = new Map();
  }

  show(modes, followed, near) {
    const numbers = new Set(modes.map(({ number }) => number));
    for (const number of this.rows.keys()) if (!numbers.has(number)) this.drop(number);
    // The list does not shrink while modes go, so that what is below it stays where it is.
    const home = this.body.closest(".scroll");
    home.style.minHeight = `${home.offsetHeight}px`;
    const before = [...this.rows.keys()].join();
    for (const mode of modes) this.fill(this.rows.get(mode.number) ?? this.add(mode.number), mode, followed, near);
    // Rows that come push the followed one out of sight.
    if ([...this.rows.keys()].join() !== before && this.rows.has(followed)) reveal(this.rows.get(followed));
  }

  fill(row, { number, T, condition }, followed, near) {
    const texts = [...Array.from(T, (x) => fixed(x, this.places)), short(condition < 1e6 ? condition : null, 3)];
    texts.forEach((text, k) => {
      const cell = row.cells[k + 1];
      if (cell.textContent !== text) cell.textContent = text;
    });
    row.classList.toggle("near", near.has(number));
    const isFollowed = number === followed;
    if (isFollowed === row.hasAttribute("aria-current")) return;
    row.toggleAttribute("aria-current", isFollowed);
    if (isFollowed) {
      row.setAttribute("aria-current", "true");
      reveal(row);
    }
  }

  add(number) {
    const row = document.createElement("tr");
    row.dataset.mode = String(number);
    row.innerHTML = '<td><button type="button"><i class="chip"></i><span></span></button><em class="tag"></em></td><td></td><td></td><td></td><td></td>';
    row.querySelector("span").textContent = String(number);
    const isHome = number === this.home;
    row.querySelector(".tag").textContent = isHome ? "home" : "";
    row.querySelector("button").setAttribute("aria-label", `follow mode ${number}${isHome ? ", home" : ""}`);
    row.querySelector(".chip").style.background = this.paint(number);
    row.querySelector(".chip").dataset.cue = cueOf(number);
    row.addEventListener("click", () => this.rows.has(number) && this.onMode(number));
    this.rows.set(number, row);
    const after = [...this.body.rows].find((other) => Number(other.dataset.mode) > number);
    this.body.insertBefore(row, after ?? null);
    return row;
  }

  drop(number) {
    const row = this.rows.get(number);
    this.rows.delete(number);
    row.removeAttribute("aria-current");
    row.classList.add("gone");
    setTimeout(() => row.remove(), FADING);
  }

  repaint() {
    for (const [number, row] of this.rows) row.querySelector(".chip").style.background = this.paint(number);
  }
}

function fixed(value, places) {
  const text = value.toFixed(places);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}
