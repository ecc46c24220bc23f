"""What a calibration estimates: changes of primitives, offsets, scales, and two unknown frames.

The parameters of primitives and drives are those of their blocks.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import field, replace

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.blocks import Block, Body, blocks_of
from gspcli.catalogue.kinds import Kind
from gspcli.geometry.arrangement import Arrangement, Bodies
from gspcli.geometry.drives import drive_numbers
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
    def of(cls, instance: Instance, *, drives: bool = False, zeros: Collection[str] = ()) -> Model:
        """Return the model of an instance, all parameters free but scales and frames.

        Parameters
        ----------
        instance
            The platform as stated.
        drives
            Whether its cranks and slides are read, so that axes and rails are estimated, too.
        zeros
            The drives whose offset is estimated in place of a shift of their point along them.

        Raises
        ------
        ArgumentError
            If both points of a constraint have drives.
        """
        if drives:
            drive_numbers(instance)
        arrangement = Arrangement.of(instance)
        shifts = offsets(instance)
        shifts[arrangement.angles] *= arrangement.in_radians
        model = cls(
            arrangement.kinds,
            arrangement.length,
            arrangement.in_radians,
            tuple(blocks_of(instance, arrangement, drives=drives, zeros=zeros)),
            shifts,
            factors(instance) - 1,
            np.zeros(FRAMES),
        )
        free = np.ones(len(model.names), bool)
        free[model.geometry + 6 :] = False
        # The offset of a distance to a plane is a shift of the plane: one of both is enough.
        planes = [k for k, kind in enumerate(model.kinds) if kind.has_sides]
        free[[model.geometry + k for k in planes]] = False
        # So is that of a drive along which its points shift.
        for block, span in model.spans():
            if block.is_drive:
                free[span.stop - 2] = block.drive_name in zeros
                free[span.stop - 1] = False
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
        parts = [block.sizes(turn) for block in self.blocks]
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
        places = {(b.body, k): b for b in self.blocks if not b.is_drive for k in b.rows}
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
    def drives(self) -> tuple[Block, ...]:
        """The blocks of cranks and slides."""
        return tuple(block for block in self.blocks if block.is_drive)

    def bodies(self, readings: Array | None = None) -> Bodies:
        """Return the primitives as they are now.

        Parameters
        ----------
        readings
            Of the drives, in radians and lengths, a column for each, shape (n, m): the points are
            then those of each pose, shape (n, 6, 3).
        """
        y, x = np.zeros((2, 1 if readings is None else len(readings), 6, 3))
        u, v = np.zeros((2, 6, 3))
        for block in self.blocks:
            if not block.is_drive:
                points, units = (y, u) if block.body == "platform" else (x, v)
                rows = list(block.rows)
                points[:, rows] = self._placed(block, readings)[:, None]
                units[rows] = block.unit
        if readings is None:
            y, x = y[0], x[0]
        return Bodies(self.kinds, y, x, u, v)

    def displacements(
        self, block: Block, readings: Array | None = None
    ) -> Iterator[tuple[list[int], Array, Array]]:
        """Yield how the parameters of a block move points and turn its direction.

        Parameters
        ----------
        block
            One of the model.
        readings
            As for `bodies`.

        Yields
        ------
        rows, moves, turns
            Constraints, and derivatives by each of the s parameters, in the frame of the body: of
            their point, shape (n or 1, s, 3), and of the direction, shape (s, 3). A drive has one
            for each of the points that it moves.
        """
        still = np.zeros((block.size, 3))
        if block.is_drive:
            for point in self._points_of(block):
                yield list(point.rows), self._by_drive(block, point, readings), still
            return
        moves, turns, s = still.copy(), still, len(block.shifts)
        moves[:s], turns[s:] = block.shifts, np.cross(block.tilts, block.unit)
        drive = self._drive_of(block)
        if drive is None or drive.sort == "slide":
            yield list(block.rows), moves[None], turns
        else:
            turned = moves @ np.swapaxes(self._turn(drive, readings), 1, 2)
            yield list(block.rows), turned, turns

    def by_drives(self, readings: Array) -> Iterator[tuple[int, Block, Array]]:
        """Yield the number of a drive, a point of it, and its derivative by the reading, (n, 3)."""
        for k, drive in enumerate(self.drives):
            for point in self._points_of(drive):
                rate = self._velocity(drive, point, readings) * (1 + drive.corrections[1])
                yield k, point, np.broadcast_to(rate, (len(readings), 3))

    def _by_drive(self, drive: Block, point: Block, readings: Array | None) -> Array:
        """Return the derivatives of a point by the parameters of its drive, (n or 1, s, 3)."""
        read, q = self._reading(drive, readings), self._number(drive, readings)
        rate = self._velocity(drive, point, readings)
        corrected = np.stack((rate, rate * read[:, None]), axis=1)
        if drive.sort == "slide":
            tilted = np.cross(drive.tilts, drive.unit) * q[:, None, None]
            return np.concatenate((tilted, corrected), axis=1)
        turn, arm = self._turn(drive, readings), point.point - drive.point
        back = np.swapaxes(turn, 1, 2)
        lever = np.cross(drive.tilts, (turn @ arm)[:, None])
        tilted = lever - np.cross(drive.tilts, arm) @ back
        shifted = drive.shifts - drive.shifts @ back
        return np.concatenate((shifted, tilted, corrected), axis=1)

    def _velocity(self, drive: Block, point: Block, readings: Array | None) -> Array:
        """Return the derivative of a point by the number of its drive, shape (n or 1, 3)."""
        if drive.sort == "slide":
            q = self._number(drive, readings)
            return np.broadcast_to(drive.unit, (len(q), 3))
        arm = self._placed(point, readings) - drive.point
        return np.asarray(np.cross(drive.unit, arm))

    def _placed(self, block: Block, readings: Array | None) -> Array:
        """Return the point of a block, moved by its drive, shape (n or 1, 3)."""
        drive = self._drive_of(block)
        if drive is None or readings is None:
            return block.point[None]
        if drive.sort == "slide":
            return np.asarray(block.point + self._number(drive, readings)[:, None] * drive.unit)
        turned = self._turn(drive, readings) @ (block.point - drive.point)
        return np.asarray(drive.point + turned)

    def _reading(self, drive: Block, readings: Array | None) -> Array:
        """Return the readings of a drive, shape (n,)."""
        if readings is None:
            return np.zeros(1)
        return np.asarray(readings[:, [one is drive for one in self.drives].index(True)])

    def _number(self, drive: Block, readings: Array | None) -> Array:
        """Return the numbers q of a drive, zero as stated, shape (n,)."""
        read = self._reading(drive, readings)
        return read if readings is None else drive.numbers(read)

    def _turn(self, axis: Block, readings: Array | None) -> Array:
        return rotation_from_vector(self._number(axis, readings)[:, None] * axis.unit)

    def _drive_of(self, block: Block) -> Block | None:
        same = (b for b in self.drives if b.body == block.body and block.name in b.carried)
        return next(same, None)

    def _points_of(self, drive: Block) -> list[Block]:
        return [
            b
            for b in self.blocks
            if b.body == drive.body and b.sort == "point" and b.name in drive.carried
        ]
