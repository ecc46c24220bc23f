// The list of modes, the numbers of the pose that is shown, and the table of constraints.
import { fillList, poseFacts, reveal } from "./facts.js";
import { coordinate, rounded, short } from "./numbers.js";

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
        reveal(row);
      } else row.removeAttribute("aria-current");
    });
    const list = byId("pose");
    list.replaceChildren();
    if (index >= series.T.length) return;
    const entries = [
      ...poseFacts(this.scene, series.T[index], series.q[index], series.condition[index]),
      ...Object.entries(series.facts).map(([name, values]) => [name, short(values[index])]),
    ];
    if (series.parameter) {
      const { name, values } = series.parameter;
      entries.unshift([name, short(values[index])]);
    }
    fillList(list, entries);
    this.bonds.forEach((row, k) => {
      const isAngle = this.scene.constraints[k].kind.startsWith("A");
      row.querySelector(".measured").textContent = coordinate(series.measured[index][k], rounded(isAngle, this.scene));
    });
  }
}
