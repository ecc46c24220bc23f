// In which order a map is filled: coarse first, each cell once.

/** Squares `[column, row, side]` of a map of so many cells a side, from `coarse` cells wide to one. */
export function* squares(cells, coarse) {
  for (let side = coarse; side >= 1; side /= 2) {
    for (let row = 0; row < cells; row += side) {
      for (let column = 0; column < cells; column += side) {
        const isKnown = side < coarse && row % (2 * side) === 0 && column % (2 * side) === 0;
        if (!isKnown) yield [column, row, side];
      }
    }
  }
}
