// The numbers of one pose, as terms and what they are.
import { short, vector } from "./numbers.js";
import { explain } from "./terms.js";

/** Smaller turns, in degrees, are rounding errors. */
const NO_TURN = 1e-6;
/** Of a quaternion smaller numbers are rounding errors, in parts of what `vector` leaves out. */
const ROUNDED = 1e4;

/** Position, orientation and condition of a pose in words. */
export function poseFacts({ size, units }, T, q, condition) {
  return [
    [`position, ${units.length}`, vector(T, size)],
    ["quaternion", vector(q, ROUNDED)],
    ["turned by", turned(q)],
    ["condition", short(condition, 4)],
  ];
}

/** Fill a list of terms; what is said already stays, with the focus in it. */
export function fillList(list, entries) {
  while (list.children.length > entries.length) list.lastElementChild.remove();
  entries.forEach(([name, value], k) => {
    const row = list.children[k] ?? list.appendChild(emptyRow());
    const [term, words] = row.children;
    if (term.textContent !== name) {
      term.replaceChildren(Object.assign(document.createElement("span"), { textContent: name }));
      term.firstChild.dataset.term = name;
      explain(term);
    }
    if (words.textContent !== value) words.textContent = value;
  });
}

function emptyRow() {
  const row = document.createElement("div");
  row.append(document.createElement("dt"), document.createElement("dd"));
  return row;
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
  return angle < NO_TURN ? "0°" : `${short(angle, 5)}° about ${vector([x / sine, y / sine, z / sine])}`;
}
