"""Boxes of poses about a home pose, judged by the limits of a platform (native/reach.cpp)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import value_range
from gspcli.geometry.enclosures import above, roundings
from gspcli.geometry.euler import check_sequence, rotation_from_euler
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine, driven_points
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import apply, quaternion_from_rotation, rotation_from_quaternion
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.wording import listed

Array = NDArray[np.float64]
Keys = NDArray[np.uint64]
Conditions = NDArray[np.uint32]

#: Position of the pivot in the base, and angles about the axes of the base, from home.
PARAMETERS = ("x", "y", "z", "rx", "ry", "rz")
REGULAR, NEGATIVE = np.uint32(_kernel.REGULAR), np.uint32(_kernel.NEGATIVE)
#: Largest difference of a given matrix from a rotation.
_ROTATION = 1e-9
_RANGES = 6
#: The condition that legs and bodies have the required gap; the kernel does not test it.
GAP = np.uint32(1 << 24)
#: The first condition of those that rods reach the points of their motors.
_REACH = int(_kernel.REACH).bit_length() - 1


class Judged(NamedTuple):
    """Boxes of a grid: those proved to keep all limits, and the undecided ones.

    All other boxes are proved to violate a limit. Keys encode places in the grid (`places`).
    """

    inside: Keys
    inside_signs: Conditions
    open: Keys
    open_left: Conditions


class PoseBoxes:
    """The poses about a home pose, by six parameters, and the limits that they keep or violate.

    The parameters are the position of the pivot in the base and three angles, in radians, about
    axes parallel to those of the base: the rotation is ``E R`` with E by `rotation_from_euler`.

    Parameters
    ----------
    instance
        The platform with its limits.
    R, T
        The home pose, shapes (3, 3) and (3,).
    pivot
        The point of the platform, in its frame, that x, y, z are the position of, shape (3,).
    sequence
        The order of the axes, such as ``ZYX``.
    regular
        Whether poses of a box must also be proved not to be singular.
    working_modes
        The signs of the gains of cranks and slides, shape (6,). If None they are those of the
        stated home, or, without one, those of the pose.
    gap
        The least gap between legs and bodies; None if gaps are not tested.

    Raises
    ------
    ArgumentError
        If the home pose is not a pose, or gaps cannot be judged.
    """

    def __init__(
        self,
        instance: Instance,
        R: ArrayLike,
        T: ArrayLike,
        *,
        pivot: ArrayLike = (0.0, 0.0, 0.0),
        sequence: str = "ZYX",
        regular: bool = False,
        working_modes: ArrayLike | None = None,
        gap: float | None = None,
    ) -> None:
        self.instance = instance
        self.sequence = check_sequence(sequence)
        given, T = np.asarray(R, float), np.asarray(T, float)
        self.pivot = np.asarray(pivot, float)
        if given.shape != (3, 3) or T.shape != (3,) or self.pivot.shape != (3,):
            message = (
                f"R has shape {given.shape}, T {T.shape} and pivot {self.pivot.shape}, "
                "expected (3, 3), (3,) and (3,)"
            )
            raise ArgumentError(message)
        if not np.isfinite([*given.flat, *T, *self.pivot]).all():
            message = "found a number that is not finite"
            raise ArgumentError(message)
        if np.abs(given @ given.T - np.eye(3)).max() > _ROTATION or np.linalg.det(given) < 0:
            message = "found a matrix that is no rotation"
            raise ArgumentError(message, "R")
        # Proofs are about the rotation of these four doubles.
        self.quaternion = quaternion_from_rotation(given)
        self.R: Array = rotation_from_quaternion(self.quaternion)
        self.home = np.concatenate((T + self.R @ self.pivot, np.zeros(3)))
        # Ball arithmetic takes long to import; it is needed for proofs of boxes only.
        from gspcli.certification.numbers.limit_balls import drive_balls, limit_balls

        self._limited, self.fixed = _with_room(instance)
        self._balls = limit_balls(self._limited, self.quaternion.tolist(), self.pivot.tolist())
        machine = Machine.of(instance)
        machine.refuse_planes("the reach")
        if working_modes is None:
            self.machine = machine.at_home(self.R, T)
        else:
            self.machine = replace(machine, signs=np.asarray(working_modes))
        #: The constraints whose point is moved, by their indices.
        self.rows: list[int] = np.flatnonzero(machine.driven).tolist()
        assert self.machine.signs is not None
        signs = self.machine.signs.tolist()
        self._moved = drive_balls(instance, self.quaternion.tolist(), self.pivot.tolist(), signs)
        order = sequence if sequence.isupper() else sequence[::-1]
        # The kernel has the angles in the order of the product.
        self._order = [0, 1, 2, *(3 + "xyz".index(letter) for letter in order.lower())]
        self._turn = np.array([k - 3 for k in self._order[3:]], np.int32)
        self.cones = machine.cones
        self.regular = regular
        self.gap = gap
        if gap is not None and not np.isfinite(gap):
            raise ArgumentError(f"found {gap}, expected a finite number", "gap")
        self._compared = None if gap is None else ComparedShapes(instance)

    @property
    def middle(self) -> str:
        """The second of the three angles, for which half a turn covers all rotations."""
        return PARAMETERS[self._order[4]]

    @property
    def conditions(self) -> np.uint32:
        """The conditions that a pose must keep, as bits.

        Ranges, of values or of the motors that move points; cones; that the rods reach the points
        of their motors; regularity.
        """
        ranged = [k for k, row in enumerate(self._limited.constraints) if row.limits is not None]
        bits = [k for k in ranged if k not in self.rows] + self._ranged
        bits += [_RANGES + k for k in range(len(self.cones))]
        found = np.uint32(sum(1 << bit for bit in bits)) | (self.reached & ~REGULAR)
        found |= REGULAR if self.regular else np.uint32(0)
        return np.uint32(found if self.gap is None else found | GAP)

    @property
    def reached(self) -> np.uint32:
        """The conditions that rods reach the points of their motors, and regularity."""
        return np.uint32(sum(1 << (_REACH + k) for k in self.rows)) | REGULAR

    def names(self, conditions: int) -> list[str]:
        """Return the conditions of some bits in words."""
        found = []
        for k in range(_RANGES):
            name = self.machine.names[self.machine.index[k]].replace(".", " ")
            if k in self.rows and conditions >> (_REACH + k) & 1:
                (one,) = driven_points(self.instance.constraints[k])
                found.append(f"reach of {one.name or k + 1}")
            elif (conditions & self.fixed) >> k & 1:
                found.append(f"fixed value of {k + 1}")
            elif conditions >> k & 1:
                found.append(f"range of {name}")
        found += [
            f"cone of {cone.constraint + 1} ({cone.body})"
            for k, cone in enumerate(self.cones)
            if conditions >> (_RANGES + k) & 1
        ]
        found += ["gap"] if conditions & int(GAP) else []
        # Without the places of all motors regularity is not judged.
        known = not any(name.startswith("reach") for name in found)
        return found + (["singularity"] if known and conditions & int(REGULAR) else [])

    def bounds(self, *, turning: bool = True) -> Array:
        """Return a box that contains all poses that keep the limits, shape (6, 2).

        Positions are bounded by legs (DPP) with a range or with a motor that moves one end; without
        such legs they are infinite. Angles are bounded by a whole turn, the middle one of the three
        by half a turn; they are zero for the orientation of home.
        """
        half = np.full(6, np.inf)
        half[3:] = np.pi
        half[self._order[4]] = np.pi / 2
        low, high = -half, half
        for turned in (True,) if turning else (True, False):
            for length, places in self._legs():
                ends = []
                for y, x, margin in places:
                    size = float(np.linalg.norm(y))
                    centre, far = (x, length + size) if turned else (x - y, length)
                    far = far + 1e-9 * (length + size + np.abs(x).max()) + margin
                    ends.append((centre - far, centre + far))
                least, most = np.swapaxes(ends, 0, 1)
                low[:3] = np.maximum(low[:3], least.min(axis=0))
                high[:3] = np.minimum(high[:3], most.max(axis=0))
        if not turning:
            low[3:] = high[3:] = 0.0
        return np.stack((low, np.maximum(low, high)), axis=1)

    def _legs(self) -> Iterator[tuple[float, list[tuple[Array, Array, Array]]]]:
        """Yield the greatest lengths of legs, with their points at home, y and x, and margins."""
        for k, row in enumerate(self._limited.constraints):
            y, x = self._balls.vectors[k, 0, :, 0], self._balls.vectors[k, 2, :, 0]
            if k in self.rows:
                yield row.value.value, self._places(k, y, x)
            elif row.kind is DPP and row.limits is not None:
                yield row.limits[1].value, [(y, x, np.zeros(3))]

    @property
    def _ranged(self) -> list[int]:
        """The constraints whose motor has a range."""
        low = self.machine.low[self.machine.index]
        return [k for k in self.rows if np.isfinite(low[k])]

    def _places(self, constraint: int, y: Array, x: Array) -> list[tuple[Array, Array, Array]]:
        """Return the points of platform and base that a rod joins, and a margin, shapes (3,).

        The point that the motor moves is between two returned places, or within the margin of one.
        The other point is that of the kernel.
        """
        assert self._moved is not None
        k = self.rows.index(constraint)
        middle, across, beside, _, first, last = self._moved.vectors[k, ..., 0]
        slide, on_platform = self._moved.sorts[k].tolist()
        none = np.zeros(3)
        found: list[tuple[Array, Array]]
        if not slide:
            margin = np.hypot(across, beside)
            found = [(middle, np.full(3, np.linalg.norm(across)) if on_platform else margin)]
        elif constraint in self._ranged:
            found = [(first, none), (last, none)]
        else:
            free = np.full(3, np.inf) if on_platform else np.where(across != 0, np.inf, 0.0)
            found = [(middle, free)]
        return [
            (point, x, margin) if on_platform else (y, point, margin) for point, margin in found
        ]

    def refuse_shared(self, R: Array, free: Sequence[str]) -> None:
        """Raise unless rods that share a drive need the same place of it at all poses that vary."""
        drives, instance = self.machine, self.instance
        turning = any(name.startswith("r") for name in free)
        for drive in range(drives.count):
            first, *others = drives.users(drive)
            for k in others:
                rows = instance.constraints[first], instance.constraints[k]
                text = f"rods {first + 1} and {k + 1} share {drives.names[drive].replace('.', ' ')}"
                if turning:
                    message = (
                        f"{text}: what such a machine reaches when it turns is not computed, "
                        "only its positions (x, y, z)"
                    )
                    raise ArgumentError(message + _ADVICE)
                y = rows[0].platform.point - rows[1].platform.point
                x = rows[0].base.point - rows[1].base.point
                off = np.linalg.norm(R @ y - x) + abs(rows[0].value.value - rows[1].value.value)
                # The difference of points on one arm turns with it.
                own = y if drives.on_platform[k] else x
                if drives.sorts[drive] == "crank":
                    axis = np.cross(drives.across[k], drives.beside[k])
                    off += np.linalg.norm(np.cross(own, axis / np.linalg.norm(axis)))
                if off > _SAME * np.linalg.norm(np.concatenate((rows[0].platform.point, x, y))):
                    message = (
                        f"{text} and are not parallel at this orientation: what such a machine "
                        "reaches is computed only where they are"
                    )
                    raise ArgumentError(message + _ADVICE)

    def refuse_fixed(self, bounds: Array, free: Sequence[int]) -> None:
        """Raise if a value that home keeps, and that stays, is not proved the same in a whole box.

        Poses that keep such a value have no volume. If home does not keep it no pose is near, and
        what the division proves is the answer.

        Raises
        ------
        ArgumentError
            Naming the values.
        """
        here = values_at(self.instance, self.R, self.home[:3] - self.R @ self.pivot)
        limited = Machine.of(self._limited)
        at_home = ~limited.outside(limited.of_values(here))[limited.index]
        one, changed = np.zeros(1, np.uint64), []
        for k in (k for k in range(_RANGES) if self.fixed >> k & 1 and at_home[k]):
            asked = np.array([1 << k], np.uint32)
            if not len(self.judge(bounds, free, 0, one, asked, split=False).inside):
                changed.append(str(k + 1))
        if changed:
            names = listed([PARAMETERS[k] for k in free], "and")
            what, them = ("value", "it") if len(changed) == 1 else ("values", "them")
            raise ArgumentError(
                f"of {what} {listed(changed, 'and')} none changes, and poses that keep {them} have "
                f"no volume in {names}\nask for the travel of each axis (gsp workspace), for poses "
                f"that keep {them} (gsp measure --nearest, gsp track), or give a wider range"
            )

    def judge(
        self,
        bounds: Array,
        free: Sequence[int],
        level: int,
        keys: Keys,
        left: Conditions,
        *,
        split: bool,
        jobs: int = 1,
    ) -> Judged:
        """Judge boxes of the grid that halves the free parameters of a box `level` times.

        Parameters
        ----------
        bounds
            The box, shape (6, 2); a parameter that is not free has its first number.
        free
            The indices of the free parameters, d of them.
        level
            The level of the grid.
        keys, left
            Boxes, shape (n,), and the conditions that are not yet proved for them. With `split`
            they are boxes of the level before, and their 2^d parts are judged.
        jobs
            Threads; the answer does not depend on them.
        """
        inverse = np.argsort(self._order)
        found = _kernel.judge_boxes(
            *self._balls,
            self._turn,
            bounds=np.ascontiguousarray(bounds[self._order]),
            free=np.array([inverse[k] for k in free], np.int32),
            level=level,
            keys=keys,
            left=left,
            split=split,
            jobs=jobs,
            drives=self._moved,
        )
        judged, compared = Judged(*found), self._compared
        return (
            judged if compared is None else self._with_gaps(compared, judged, bounds, free, level)
        )

    def _with_gaps(
        self,
        compared: ComparedShapes,
        judged: Judged,
        bounds: Array,
        free: Sequence[int],
        level: int,
    ) -> Judged:
        """Test the gaps of the boxes that the kernel did not decide."""
        keys, left = judged.open, judged.open_left.copy()
        asked = np.flatnonzero(left & GAP)
        if not len(asked):
            return judged
        assert self.gap is not None
        parameters = np.tile(bounds[:, 0], (len(asked), 1))
        half = np.zeros(6)
        span = bounds[free, 1] - bounds[free, 0]
        place = places(keys[asked], len(free)) + 0.5
        parameters[:, free] = bounds[free, 0] + place * 2.0**-level * span
        half[free] = 2.0 ** -(level + 1) * span
        half = above(half) + roundings(4, np.abs(bounds).max(axis=1))
        R, T = self.poses(parameters)
        turn = above(half[3:].sum())
        shifts, turns = (np.full(len(asked), x) for x in (above(np.linalg.norm(half[:3])), turn))
        at = R, T, self.machine.inverse(R, T) if self.rows else None
        with np.errstate(invalid="ignore"):
            moves = compared.moves(*at, shifts, turns, self.pivot)
        found = compared.bounds(*at)
        left[asked[(found.low - moves >= self.gap).all(axis=1)]] &= ~GAP
        inside = (left & ~NEGATIVE) == 0
        still = ~inside
        still[asked[(found.high + moves < self.gap).any(axis=1)]] = False
        return Judged(
            np.concatenate((judged.inside, keys[inside])),
            np.concatenate((judged.inside_signs, left[inside])),
            keys[still],
            left[still],
        )

    def poses(self, parameters: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) of parameters, ``(..., 6) -> (..., 3, 3), (..., 3)``."""
        R = rotation_from_euler(self.sequence, parameters[..., 3:]) @ self.R
        return R, parameters[..., :3] - apply(
            R, np.broadcast_to(self.pivot, (*parameters.shape[:-1], 3))
        )


def _with_room(instance: Instance) -> tuple[Instance, int]:
    """Return an instance in which values that stay have a range: 1e-9 of the size either way.

    Also returned are the bits of these values.
    """
    drives, rows = Machine.of(instance), list(instance.constraints)
    room = _SAME * Arrangement.of(instance).length, _SAME / instance.units.angle.in_radians
    fixed = np.flatnonzero(drives.fixed).tolist()
    for k in fixed:
        row = rows[k]
        value = (row.value if row.limits is None else row.limits[0]).value
        lowest, highest = value_range(row.kind, instance.units.angle)
        off = room[not row.kind.is_distance]
        ends = max(value - off, lowest), min(value + off, highest)
        rows[k] = replace(row, limits=(Number.of(ends[0]), Number.of(ends[1])))
    return replace(instance, constraints=tuple(rows)), sum(1 << k for k in fixed)


def places(keys: Keys, dimensions: int) -> NDArray[np.int64]:
    """Return the places in the grid of keys, ``(n,) -> (n, d)``."""
    bits = 64 // dimensions
    mask = np.uint64(2**bits - 1)
    columns = [(keys >> np.uint64(d * bits)) & mask for d in range(dimensions)]
    return np.stack(columns, axis=-1).astype(np.int64)


#: Rods with one drive must need the same place of it, up to this part of the size.
_SAME = 1e-9
_ADVICE = (
    "\nwrite a machine of parallel rods as three distances (DPP) and three angles that stay "
    "constant"
)


class BoxSet(NamedTuple):
    """Boxes by their keys in the grid of their level, with the conditions of each, shape (n,)."""

    keys: Keys
    conditions: Conditions
    levels: NDArray[np.int32]

    @classmethod
    def of_level(cls, keys: Keys, conditions: Conditions, level: int) -> BoxSet:
        """Return boxes of one level."""
        return cls(keys, conditions, np.full(len(keys), level, np.int32))

    @classmethod
    def joined(cls, parts: Sequence[BoxSet]) -> BoxSet:
        """Return the boxes of all parts, one after the other."""
        nothing = cls.of_level(np.zeros(0, np.uint64), np.zeros(0, np.uint32), 0)
        return cls(*map(np.concatenate, zip(nothing, *parts, strict=True)))

    def chosen(self, which: NDArray[np.bool_] | slice) -> BoxSet:
        """Return some of the boxes."""
        return BoxSet(self.keys[which], self.conditions[which], self.levels[which])

    def corners(self, bounds: Array) -> Array:
        """Return the ends of the boxes in each parameter of the divided box, shape (n, d, 2)."""
        low, high = bounds.T
        step = (high - low) / 2.0 ** self.levels[:, None]
        place = places(self.keys, len(bounds))
        return np.stack((low + place * step, low + (place + 1) * step), axis=2)
