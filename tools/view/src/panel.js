// The list of modes, the numbers of the pose that is shown, and the table of constraints.
import { coordinate, short, vector } from "./numbers.js";

const byId = (id) => document.getElementById(id);

export class Panel {
  constructor(scene, { onMode, onBond }) {
    this.scene = scene;
    this.rows = [...document.querySelectorAll("#modes tbody tr")];
    this.rows.forEach((row, k) => row.addEventListener("click", () => onMode(k)));
    this.bonds = [...document.querySelectorAll("#constraints tbody tr")];
    this.bonds.forEach((row, k) => {
      row.addEventListener("pointerenter", () => onBond(k));
      row.addEventListener("pointerleave", () => onBond(null));
    });
  }

  colourModes(scale) {
    const { condition } = this.scene.series[0];
    this.rows.forEach((row, k) => {
      row.querySelector("i.chip").style.background = `#${scale.colour(condition[k]).getHexString()}`;
    });
  }

  choose(bond) {
    this.bonds.forEach((row, k) => row.classList.toggle("chosen", k === bond));
  }

  show(series, index) {
    const isModes = series === this.scene.series[0];
    this.rows.forEach((row, k) => {
      const current = isModes && k === index;
      if (current) {
        row.setAttribute("aria-current", "true");
        this.reveal(row);
      } else row.removeAttribute("aria-current");
    });
    const list = byId("pose");
    list.replaceChildren();
    if (index >= series.T.length) return;
    const { size, units } = this.scene;
    const entries = [
      [`position, ${units.length}`, vector(series.T[index], size)],
      ["quaternion", vector(series.q[index])],
      ["turned by", turned(series.q[index])],
      ["condition", short(series.condition[index], 4)],
      ...Object.entries(series.facts).map(([name, values]) => [name, short(values[index])]),
    ];
    if (series.parameter) {
      const { name, values } = series.parameter;
      entries.unshift([name, short(values[index])]);
    }
    for (const [name, value] of entries) {
      const row = document.createElement("div");
      const term = document.createElement("dt");
      const words = document.createElement("dd");
      term.textContent = name;
      words.textContent = value;
      row.append(term, words);
      list.append(row);
    }
    this.bonds.forEach((row, k) => {
      const isAngle = this.scene.constraints[k].kind.startsWith("A");
      row.querySelector(".measured").textContent = coordinate(series.measured[index][k], isAngle ? 180 : size);
    });
  }

  /** Scroll the list, and nothing else, so that a row is seen. */
  reveal(row) {
    const home = row.closest(".scroll");
    const box = home.getBoundingClientRect();
    const place = row.getBoundingClientRect();
    const head = home.querySelector("thead").getBoundingClientRect().height;
    if (place.top < box.top + head) home.scrollTop -= box.top + head - place.top;
    else if (place.bottom > box.bottom) home.scrollTop += place.bottom - box.bottom;
  }
}

function turned([w, x, y, z]) {
  const sine = Math.hypot(x, y, z);
  const angle = (2 * Math.atan2(sine, w) * 180) / Math.PI;
  return sine < 1e-12 ? "0°" : `${short(angle, 5)}° about ${vector([x / sine, y / sine, z / sine])}`;
}
