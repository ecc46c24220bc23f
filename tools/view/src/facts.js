// The numbers of one pose, as terms and what they are.
import { short, vector } from "./numbers.js";

/** Position, orientation and condition of a pose in words. */
export function poseFacts({ size, units }, T, q, condition) {
  return [
    [`position, ${units.length}`, vector(T, size)],
    ["quaternion", vector(q)],
    ["turned by", turned(q)],
    ["condition", short(condition, 4)],
  ];
}

/** Fill a list of terms. */
export function fillList(list, entries) {
  list.replaceChildren(...entries.map(([name, value]) => {
    const row = document.createElement("div");
    const term = document.createElement("dt");
    const words = document.createElement("dd");
    term.textContent = name;
    words.textContent = value;
    row.append(term, words);
    return row;
  }));
}

/** Scroll the list that a row is in, and nothing else, so that the row is seen. */
export function reveal(row) {
  const home = row.closest(".scroll");
  const box = home.getBoundingClientRect();
  const place = row.getBoundingClientRect();
  const head = home.querySelector("thead").getBoundingClientRect().height;
  if (place.top < box.top + head) home.scrollTop -= box.top + head - place.top;
  else if (place.bottom > box.bottom) home.scrollTop += place.bottom - box.bottom;
}

function turned([w, x, y, z]) {
  const sine = Math.hypot(x, y, z);
  const angle = (2 * Math.atan2(sine, w) * 180) / Math.PI;
  return sine < 1e-12 ? "0°" : `${short(angle, 5)}° about ${vector([x / sine, y / sine, z / sine])}`;
}
