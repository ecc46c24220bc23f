// The text about the state.
import { short } from "../numbers.js";

const plural = (count, one, many = `${one}s`) => `${count} ${count === 1 ? one : many}`;
const ways = (real) => (real ? `${plural(real, "way")} to assemble it` : "no way to assemble it");

/**
 * How many ways there are to assemble it, and how sure that is: a sentence, the numbers behind it,
 * whether these are proved, and its kind (good, open, busy).
 */
export function accountText({ complete, isPossible, expected, proved, real }, isCounted) {
  if (!isPossible) return { kind: "open", text: "no pose has such values: distances are not negative, angles have ends", more: "" };
  if (complete) {
    return { kind: "good", text: real ? `${ways(real)}; none is missing` : ways(real), more: `${plural(proved, "pose")}, ${real} real:`, isProved: true };
  }
  const known = real ? `${ways(real)} ${real === 1 ? "is" : "are"} known` : "no way to assemble it is known";
  if (proved < expected) {
    return { kind: "open", text: known, more: `${proved} of ${plural(expected, "pose")} proved, ${expected - proved} missing` };
  }
  const why = isCounted ? "that they are all different is not proved" : "that there are no more is not proved";
  return { kind: "open", text: known, more: `${plural(proved, "pose")} proved; ${why}` };
}

/** The same in one sentence, for those who listen. */
export function accountSpoken(account, isCounted) {
  const { text, more, isProved } = accountText(account, isCounted);
  return [text, more && `${more}${isProved ? " proved" : ""}`].filter(Boolean).join("; ");
}

/** What is said where no mode is followed. */
export function noModeText({ complete, isPossible, real }, ahead) {
  if (ahead?.isOpening) return "";
  if (ahead) return "The followed mode could not be followed all the way.";
  if (real) return "No mode is followed. Choose one in the list.";
  return complete || !isPossible ? "There is no real pose for these values." : "No real pose is known for these values.";
}

/**
 * Which way leads home, and what is proved of it, in a sentence. `words`: whether values are those of motors or all
 * are lengths of legs, whether the file has ranges, and cones (null: not tested).
 */
export function wayText(found, { isMotors, isLegs, ranges, cones }) {
  if (!found) return "";
  if (found.isHome) return "It is at home.";
  if (found.reason === "sign") {
    return `No safe way home: all ways pass ${isMotors ? "a singular pose or a dead point" : "a singular pose; det J has the other sign there"}.`;
  }
  if (found.reason) return "No safe way home was found.";
  const values = isMotors ? "motors" : isLegs ? "leg lengths" : "values";
  const how = {
    values: () => `by straight ${values}`, poses: () => "by straight poses",
    stored: () => `through ${plural(found.stored, "stored pose")}`,
  }[found.kind]();
  const limits = [];
  if (ranges) limits.push(found.outside ? "it begins outside the limits" : "ranges kept");
  if (cones) limits.push("cones looked at in places");
  if (cones === null) limits.push("cones not looked at");
  return `Home ${how}: proved, not singular${limits.map((x) => `; ${x}`).join("")}.`;
}

/** What happened in a move, in which `followed` was followed; empty if nothing did. */
export function eventText({ met = [], gone = [], passed = null, followed = null, unreached = false, way = null }, words) {
  const said = [];
  if (way) said.push(`${wayText(way, words)}${way.reason ? " Home jumps there." : ""}`);
  if (unreached) said.push("the motors cannot bring the rods to that pose");
  if (passed) said.push(`through a singular pose: from mode ${passed[0]} into mode ${passed[1]}`);
  if (met.length) {
    const pairs = met.map(({ modes }) => modes.map(({ number }) => number));
    const lost = pairs.flat().includes(followed) ? "; none is followed now" : "";
    said.push(`modes ${pairs.map(([a, b]) => `${a} and ${b}`).join(", ")} have met and vanished${lost}`);
  }
  if (gone.length === 1) said.push(`mode ${gone[0].number} is no longer found`);
  else if (gone.length) said.push(`modes ${gone.map(({ number }) => number).join(", ")} are no longer real`);
  return said.join("; ");
}

/** Which two modes come near each other, and how near. */
export function foldText(mode, { other }, { length, units }) {
  const apart = Math.hypot(...mode.T.map((x, k) => x - other.T[k]));
  const turn = turnBetween(mode.q, other.q);
  return `near a fold: mode ${mode.number} and mode ${other.number} are ${short(apart, 3)} ${units.length} and `
    + `${short(turn, 3)}° apart, condition ${short(mode.condition, 3)}`;
}

function turnBetween(p, q) {
  const cosine = Math.min(1, Math.abs(p.reduce((sum, x, k) => sum + x * q[k], 0)));
  const sine = Math.sqrt(Math.max(0, 1 - cosine * cosine));
  return (2 * Math.atan2(sine, cosine) * 180) / Math.PI;
}

/** The share of each number of real modes in the map. */
export function sharesText(shares) {
  return shares.map(({ count, part }) => `${count}: ${part < 0.01 ? "below 1" : Math.round(100 * part)} %`).join(", ");
}
