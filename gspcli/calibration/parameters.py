"""What a calibration estimates: changes of primitives, offsets, scales, and two unknown frames.

The parameters of the primitives are those of their blocks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.blocks import Block, Body, blocks_of
from gspcli.catalogue.kinds import Kind
from gspcli.geometry.arrangement import Arrangement, Bodies
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.readings import factors, offsets
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: A pose of the measuring device and one of the target: turns (3), then shifts (3), of each.
FRAMES = 12
_FRAME_NAMES = tuple(
    f"{frame}.{q}" for frame in ("device", "target") for q in ("rx", "ry", "rz", "x", "y", "z")
)


@dataclass(frozen=True, eq=False)
class Model:
    """A platform whose numbers can change.

    Attributes
    ----------
    kinds
        The kinds of the six constraints.
    length
        A typical length, in which turns are weighed against shifts.
    in_radians
        The unit of angles.
    blocks
        The primitives.
    offsets, scales
        What is added to readings, in units of length and radians, and what they are multiplied by,
        less one; shapes (6,).
    frames
        The pose of the base in the measuring device's frame and that of the target in the
        platform's: a rotation vector and a shift each, shape (12,).
    free
        Which of all parameters are estimated, shape (p,).
    """

    kinds: tuple[Kind, ...]
    length: float
    in_radians: float
    blocks: tuple[Block, ...]
    offsets: Array
    scales: Array
    frames: Array
    free: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    @classmethod
    def of(cls, instance: Instance, *, cranks: bool = False) -> Model:
        """Return the model of an instance, all parameters free but scales and frames.

        Parameters
        ----------
        instance
            The platform as stated.
        cranks
            Whether the angles of its cranks are known, so that their axes are estimated, too.
        """
        arrangement = Arrangement.of(instance)
        shifts = offsets(instance)
        shifts[arrangement.angles] *= arrangement.in_radians
        model = cls(
            arrangement.kinds,
            arrangement.length,
            arrangement.in_radians,
            tuple(blocks_of(instance, arrangement, cranks=cranks)),
            shifts,
            factors(instance) - 1,
            np.zeros(FRAMES),
        )
        free = np.ones(len(model.names), bool)
        free[model.geometry + 6 :] = False
        # The offset of a distance to a plane is a shift of the plane: one of both is enough.
        planes = [k for k, kind in enumerate(model.kinds) if kind.has_sides]
        free[[model.geometry + k for k in planes]] = False
        return replace(model, free=free)

    @property
    def geometry(self) -> int:
        """How many parameters the primitives have; offsets, scales and frames follow."""
        return sum(block.size for block in self.blocks)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all parameters."""
        geometry = [name for block in self.blocks for name in block.names]
        numbers = range(1, len(self.kinds) + 1)
        values = [f"{what}.{k}" for what in ("offset", "scale") for k in numbers]
        return (*geometry, *values, *_FRAME_NAMES)

    @property
    def sizes(self) -> Array:
        """The change of each parameter that moves values by about a length of one, shape (p,)."""
        turn = 1 / self.length
        parts = [[1.0] * len(b.shifts) + [turn] * len(b.tilts) for b in self.blocks]
        parts.append([1.0 if kind.is_distance else turn for kind in self.kinds])
        parts.append([turn] * len(self.kinds))
        parts.append(([turn] * 3 + [1.0] * 3) * 2)
        return np.concatenate(parts)

    @property
    def with_frames(self) -> bool:
        """Whether the frames of device and target are estimated."""
        return bool(self.free[self.geometry + 12 :].any())

    def spans(self) -> Iterator[tuple[Block, slice]]:
        """Yield the blocks and where their parameters are."""
        at = 0
        for block in self.blocks:
            yield block, slice(at, at + block.size)
            at += block.size

    def moved(self, step: Array) -> Model:
        """Return the model after a step of all parameters, shape (p,)."""
        at = self.geometry
        return replace(
            self,
            blocks=tuple(block.moved(step[span]) for block, span in self.spans()),
            offsets=self.offsets + step[at : at + 6],
            scales=self.scales + step[at + 6 : at + 12],
            frames=self.frames + step[at + 12 :],
        )

    def anchored(self, R: Array, T: Array) -> Model:
        """Return the same with the points of lines and planes near what is measured at poses."""
        places = {(b.body, k): b for b in self.blocks if b.sort != "crank" for k in b.rows}
        found = []
        for block in self.blocks:
            if block.sort in ("line", "plane"):
                other: Body = "base" if block.body == "platform" else "platform"
                ends = [places[other, k] for k in block.rows]
                near = [b.point for b in ends if b.sort == "point"] or [np.zeros(3)]
                if block.body == "base":
                    block = block.anchored((R @ np.mean(near, axis=0) + T).mean(axis=0))
                elif ends[0].sort == "point":
                    away = np.mean(near, axis=0) - T
                    block = block.anchored(np.einsum("nba,nb->na", R, away).mean(axis=0))
                else:
                    block = block.anchored(np.zeros(3))
            found.append(block)
        return replace(self, blocks=tuple(found))

    @property
    def cranks(self) -> tuple[Block, ...]:
        """The blocks of cranks."""
        return tuple(block for block in self.blocks if block.sort == "crank")

    def bodies(self, angles: Array | None = None) -> Bodies:
        """Return the primitives as they are now.

        Parameters
        ----------
        angles
            Of the cranks, in radians, a column for each, shape (n, m): the points are then those of
            each pose, shape (n, 6, 3).
        """
        y, x = np.zeros((2, 1 if angles is None else len(angles), 6, 3))
        u, v = np.zeros((2, 6, 3))
        for block in self.blocks:
            if block.sort != "crank":
                points, units = (y, u) if block.body == "platform" else (x, v)
                rows = list(block.rows)
                points[:, rows] = self._placed(block, angles)[:, None]
                units[rows] = block.unit
        if angles is None:
            y, x = y[0], x[0]
        return Bodies(self.kinds, y, x, u, v)

    def displacements(self, block: Block, angles: Array | None = None) -> tuple[Array, Array]:
        """Return how the parameters of a block move its point and turn its direction.

        Parameters
        ----------
        block
            One of the model.
        angles
            As for `bodies`.

        Returns
        -------
        moves, turns
            Derivatives by each of the s parameters, in the frame of the body: of the point, shape
            (n or 1, s, 3), and of the direction, shape (s, 3). The parameters of a crank move the
            point that it turns.
        """
        still = np.zeros((block.size, 3))
        s = len(block.shifts)
        if block.sort == "crank":
            turn = self._turn(block, angles)
            arm = self._point_of(block).point - block.point
            lever = np.cross(block.tilts, (turn @ arm)[:, None])
            tilted = lever - np.cross(block.tilts, arm) @ np.swapaxes(turn, 1, 2)
            shifted = block.shifts - block.shifts @ np.swapaxes(turn, 1, 2)
            return np.concatenate((shifted, tilted), axis=1), still
        moves, turns = still.copy(), still
        moves[:s], turns[s:] = block.shifts, np.cross(block.tilts, block.unit)
        axis = self._crank_of(block)
        if axis is None or angles is None:
            return moves[None], turns
        return moves @ np.swapaxes(self._turn(axis, angles), 1, 2), turns

    def by_angles(self, angles: Array) -> Iterator[tuple[Block, Array]]:
        """Yield each crank and the derivative of its point by its angle, shape (n, 3)."""
        for axis in self.cranks:
            arm = self._placed(self._point_of(axis), angles) - axis.point
            yield axis, np.cross(axis.unit, arm)

    def _placed(self, block: Block, angles: Array | None) -> Array:
        """Return the point of a block, turned by its crank, shape (n or 1, 3)."""
        axis = self._crank_of(block)
        if axis is None or angles is None:
            return block.point[None]
        placed: Array = axis.point + self._turn(axis, angles) @ (block.point - axis.point)
        return placed

    def _turn(self, axis: Block, angles: Array | None) -> Array:
        if angles is None:
            return np.eye(3)[None]
        column = [one is axis for one in self.cranks].index(True)
        return rotation_from_vector(angles[:, column, None] * axis.unit)

    def _crank_of(self, block: Block) -> Block | None:
        same = [b for b in self.cranks if (b.body, b.name) == (block.body, block.name)]
        return same[0] if same else None

    def _point_of(self, axis: Block) -> Block:
        key = axis.body, axis.name, "point"
        return next(b for b in self.blocks if (b.body, b.name, b.sort) == key)
