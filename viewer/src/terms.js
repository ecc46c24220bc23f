// What the words of the page mean: shown when one points at them or comes to them with the keyboard.

const SORTS = { P: "point", L: "line", H: "plane" };
const MEANINGS = {
  proved: "Interval arithmetic has proved that each pose exists, and how many there are. Poses that are not real (with complex numbers) count among them.",
  condition: "How badly the pose is determined by its values: 1 is best. A small change of the values moves the pose by up to so much more. Infinite: singular.",
  "pose clearance": "The pose may change by this much, in any direction, before it can be singular. The bound is proved. Turns count by the way of the platform's points.",
  crank: "A motor turns an arm, at whose end the joint of the rod is.",
  slide: "A motor moves a carriage on a rail, and with it the joint of the rod.",
  mode: "An assembly mode: one real pose that the six values allow. It keeps its number while the values change.",
};
/** Letters of a kind: distance or angle, of which parts of the platform and the base. */
const KIND = /^([DA])([PLH])([PLH])$/;
/** Pixels between a word and its explanation, and to the edge of the window. */
const GAP = 6;

/** The meaning of a word or a kind; undefined if there is none. */
export function meaning(word) {
  const kind = KIND.exec(word);
  if (!kind) return MEANINGS[word];
  const [, what, platform, base] = kind;
  return `${word}: ${what === "D" ? "distance" : "angle"} between a ${SORTS[platform]} of the platform and a ${SORTS[base]} of the base`;
}

/** Make the words of the terms under a part of the page explain themselves. */
export function explain(root) {
  for (const word of root.querySelectorAll(".kind, [data-term]")) {
    const text = meaning(word.dataset.term ?? word.textContent.trim());
    if (!text || word.hasAttribute("tabindex")) continue;
    word.classList.add("term");
    word.tabIndex = 0;
    word.setAttribute("aria-description", text);
  }
}

/** Show the explanation of a term while the pointer or the focus is on it; Escape takes it away. */
export function showMeanings() {
  const tip = document.createElement("div");
  tip.id = "meaning";
  tip.hidden = true;
  tip.setAttribute("aria-hidden", "true");
  document.body.append(tip);
  let word = null;
  const say = (one) => {
    word = one;
    tip.hidden = !word;
    if (word) place(tip, word);
  };
  const show = ({ target }) => say(target instanceof Element ? target.closest(".term") : null);
  const hide = () => say(null);
  document.addEventListener("pointerover", show);
  document.addEventListener("focusin", show);
  document.addEventListener("focusout", hide);
  // Focus may scroll the word into sight.
  document.addEventListener("scroll", () => say(word), true);
  document.addEventListener("keydown", (event) => event.key === "Escape" && hide());
}

function place(tip, word) {
  tip.textContent = word.getAttribute("aria-description");
  const at = word.getBoundingClientRect();
  const { width, height } = tip.getBoundingClientRect();
  const left = Math.max(GAP, Math.min(at.left, document.documentElement.clientWidth - width - GAP));
  const below = at.bottom + GAP;
  const top = below + height < window.innerHeight ? below : at.top - GAP - height;
  tip.style.left = `${left}px`;
  tip.style.top = `${Math.max(GAP, top)}px`;
}
