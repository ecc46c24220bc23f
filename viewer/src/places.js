// Where names and numbers stand, so that none hides another.

/** Steps from the point to the label: beside it first, then around, then farther away. */
const NEAR = [[1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]];
const AROUND = [1, 1.8, 3].flatMap((far) => NEAR.map(([right, down]) => [far * right, far * down]));
/** A number may stand on its stroke itself. */
const ON = [[0, 0], ...AROUND];
/** Pixels between a point and its name, and from the edge of the picture. */
const GAP = 6;
/** Half of the side of the square around a point that no name covers. */
const POINT = 5;

function overlap(a, b) {
  const width = Math.min(a.right, b.right) - Math.max(a.left, b.left);
  const height = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
  return width > 0 && height > 0 ? width * height : 0;
}

function boxOf({ x, y, width, height, anchor }, [right, down]) {
  // Beside a point the label clears it; a number moves by its own size.
  const gap = anchor === "on" ? 1 : GAP;
  const across = right * (width / 2 + gap);
  const along = down * (height / 2 + (down && right ? gap / 2 : gap));
  const left = x + across - width / 2;
  const top = y + along - height / 2;
  return { left, top, right: left + width, bottom: top + height };
}

/** Area of a box outside the picture. */
function outside(box, width, height) {
  return (box.right - box.left) * (box.bottom - box.top) - overlap(box, { left: 0, top: 0, right: width, bottom: height });
}

/**
 * Choose `box` of each label: numbers first, then names. A label stays on its side of the point
 * while that is free, so that it does not jump when the view is turned.
 */
export function arrange(labels, width, height) {
  const points = labels.filter(({ anchor }) => anchor === "beside");
  const taken = points.map(({ x, y }) => ({ left: x - POINT, top: y - POINT, right: x + POINT, bottom: y + POINT }));
  const order = [...labels.filter(({ anchor }) => anchor === "on"), ...points];
  for (const label of order) {
    const steps = label.anchor === "on" ? ON : AROUND;
    const hidden = (step) => {
      const box = boxOf(label, step);
      return taken.reduce((sum, other) => sum + overlap(box, other), outside(box, width, height));
    };
    let best = label.step ?? steps[0];
    let least = hidden(best);
    for (const step of least > 0 ? steps : []) {
      const area = hidden(step);
      if (area < least) [best, least] = [step, area];
    }
    label.step = best;
    label.box = boxOf(label, best);
    taken.push(label.box);
  }
}
