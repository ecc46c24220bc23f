"""Where names and numbers stand on paper, so that none hides another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Between a point and its name, in points of the paper, and half of the square that is the point's.
_GAP, _POINT = 4.0, 3.5
#: How wide a stroke is that a name hides, in points of the paper.
_STROKE = 1.5
#: Distances of labels from their points, as multiples of the least one.
_FAR = (1.0, 1.8, 3.0)
#: To the right, upwards, to the left, ...: what is not free is left for the next in direction.
_COMPASS = np.array([[np.cos(a), np.sin(a)] for a in np.arange(8) * np.pi / 4]).round(9)


class Label(NamedTuple):
    """A name or a number that is to be placed.

    Attributes
    ----------
    at
        Its point on the paper, in points of the paper, shape (2,).
    size
        Width and height, shape (2,).
    way
        The direction in which it stands from its point if there is room, a unit vector of shape
        (2,); None for a number, which stands on its point then.
    """

    at: Array
    size: Array
    way: Array | None

    @property
    def shifts(self) -> Iterator[Array]:
        """The steps from the point to the middle of the label, the best first."""
        if self.way is None:
            yield np.zeros(2)
        way = np.ones(2) if self.way is None else self.way
        nearest = _COMPASS[np.argsort(-(_COMPASS @ way).round(6), kind="stable")]
        ways = nearest if self.way is None else np.vstack((self.way, nearest))
        for far in _FAR:
            yield from far * ways * (_GAP + self.size / 2)


def apart(labels: Sequence[Label], strokes: Array | None = None) -> list[Array]:
    """Return the step from its point to the middle of each label; numbers are placed first.

    Names stand beside strokes, numbers on them. Where nothing is free the label goes where it
    hides least.

    Parameters
    ----------
    labels
        What is placed.
    strokes
        Ends of straight strokes, in points of the paper, shape (n, 2, 2).
    """
    points = [label.at for label in labels if label.way is not None]
    taken = [np.stack((at - _POINT, at + _POINT)) for at in points]
    found = [np.zeros(2)] * len(labels)
    for k in sorted(range(len(labels)), key=lambda k: labels[k].way is not None):
        label = labels[k]
        shifts = [*label.shifts]
        boxes = np.array(taken).reshape(-1, 2, 2)
        hidden = [_shared(label.at + shift, label.size, boxes) for shift in shifts]
        if label.way is not None and strokes is not None and len(strokes):
            hidden = [
                area + _STROKE * _crossed(label.at + shift, label.size, strokes)
                for area, shift in zip(hidden, shifts, strict=True)
            ]
        found[k] = shifts[int(np.argmin(hidden))]
        middle = label.at + found[k]
        taken.append(np.stack((middle - label.size / 2, middle + label.size / 2)))
    return found


def _crossed(middle: Array, size: Array, strokes: Array) -> float:
    """Return the length of strokes, shape (n, 2, 2), in a label."""
    start, along = strokes[:, 0] - middle, strokes[:, 1] - strokes[:, 0]
    # Where a stroke enters and leaves the strip of each coordinate, as parts of its length.
    still = np.abs(along) < 1e-9
    safe = np.where(still, 1.0, along)
    ends = np.sort(np.stack((-size / 2 - start, size / 2 - start)) / safe, axis=0)
    inside = np.abs(start) <= size / 2
    low = np.where(still, np.where(inside, -np.inf, np.inf), ends[0]).max(axis=1)
    high = np.where(still, np.inf, ends[1]).min(axis=1)
    part = np.maximum(np.minimum(high, 1.0) - np.maximum(low, 0.0), 0.0)
    return round(float(part @ np.linalg.norm(along, axis=1)), 3)


def _shared(middle: Array, size: Array, boxes: Array) -> float:
    """Return the area that a label shares with boxes, shape (n, 2, 2)."""
    low, high = middle - size / 2, middle + size / 2
    sides = np.minimum(high, boxes[:, 1]) - np.maximum(low, boxes[:, 0])
    return round(float(np.prod(np.maximum(sides, 0), axis=1).sum()), 6)
