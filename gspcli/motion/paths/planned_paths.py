"""What planning has found: a path with its proof, a proof that there is none, or neither.

Paths and ways between nodes of a map cost their length times the condition number.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers, printed_conditions
from gspcli.geometry.readings import readings_of
from gspcli.motion.following.tracks import POSE, continuous_quaternions
from gspcli.records import Tabular, dataclass
from gspcli.wording import counted

if TYPE_CHECKING:
    from gspcli.motion.paths.timing import Timing

Array = NDArray[np.float64]
Verdict = Literal["proved", "impossible", "not found"]
_EMPTY = np.zeros((0, 6))
#: Decimals of estimated costs: last digits must not choose a way.
_DECIMALS = 6
#: Moves that are smaller are rounding errors of equal poses, in lengths of the platform.
_STILL = 1e-12


@dataclass(frozen=True)
class PathPart:
    """A straight part of a path, or a rounded corner between two.

    Attributes
    ----------
    first, last
        Its rows, from 0.
    pieces
        How many pieces its proof has.
    length
        The way of the platform's points, as a root mean square, in the unit of length.
    condition
        The largest condition number at its rows.
    clearance
        A proved lower bound of the clearance of all its poses, between the rows, too; in the units
        of `gsp clearance`. 0 if nothing is proved.
    gap
        A proved lower bound of the least gap between legs and bodies at all its poses, if one is
        asked for.
    """

    first: int
    last: int
    pieces: int
    length: float
    condition: float
    clearance: float
    gap: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the part as plain data; rows are counted from 1."""
        return {
            "rows": [self.first + 1, self.last + 1],
            "pieces": self.pieces,
            "length": self.length,
            "condition": self.condition if np.isfinite(self.condition) else None,
            "clearance": self.clearance,
            **({} if self.gap is None else {"gap": self.gap}),
        }


@dataclass(frozen=True, eq=False)
class PlannedPath(Tabular):
    """The answer of `gspcli.path`.

    Attributes
    ----------
    instance
        The platform.
    start, goal
        The ends in words, such as ``mode 3`` or ``the pose``.
    verdict
        ``proved``: the path is proved to be regular and to keep ranges and cones on the whole way.
        ``impossible``: it is proved that there is no such path. ``not found``: neither, in the time
        that was given.
    reason
        Why there is no path; empty if there is one.
    along
        Whether the values or position and angles change linearly between the rows.
    t
        A number for each row: its part of the path, counted from 0, with the fraction; seconds if
        a speed was asked for. Shape (r,).
    values
        The values at the rows, without offsets, shape (r, 6).
    R, T
        The poses, shapes (r, 3, 3) and (r, 3).
    conditions, clearances
        At the rows: condition numbers, and proved clearances, shapes (r,).
    parts
        The straight parts, and the rounded corners between them.
    timing
        What is known of the time; None without a speed.
    drives
        What the m drives of a machine with cranks or slides are at in the rows, lengths and
        radians, shape (r, m); else None.
    gaps
        The least gap between legs and bodies at the rows, shape (r,), if one is asked for.
    """

    instance: Instance
    start: str
    goal: str
    verdict: Verdict
    reason: str = ""
    along: str = ""
    t: Array = field(default_factory=lambda: np.zeros(0))
    values: Array = field(default_factory=lambda: _EMPTY)
    R: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    T: Array = field(default_factory=lambda: np.zeros((0, 3)))
    conditions: Array = field(default_factory=lambda: np.zeros(0))
    clearances: Array = field(default_factory=lambda: np.zeros(0))
    parts: tuple[PathPart, ...] = ()
    timing: Timing | None = None
    drives: Array | None = None
    gaps: Array | None = None

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        found: str = self.verdict
        if self.parts:
            found += f", {counted(self.straight, 'straight part')}"
        return f"<PlannedPath of {kinds} from {self.start} to {self.goal}: {found}>"

    @property
    def straight(self) -> int:
        """The number of straight parts."""
        return len(self.parts)

    @property
    def length(self) -> float:
        """The way of the platform's points, as a root mean square, in the unit of length."""
        return sum(part.length for part in self.parts)

    @cached_property
    def straight_length(self) -> float:
        """How far the ends are from each other, by the same measure."""
        if not len(self.T):
            return 0.0
        ends = [0, -1]
        return float(steps(self.instance, self.R[ends], self.T[ends])[0])

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns of the drives: constraints, or cranks and slides."""
        return tuple("123456") if self.drives is None else Machine.of(self.instance).names

    def _readings(self) -> Array:
        if self.drives is None:
            return readings_of(self.instance, self.values)
        return Machine.of(self.instance).readings(self.drives)

    def rows(self, frame: PoseFrame = IDENTITY) -> list[dict[str, Any]]:
        """Return the rows as plain data: t, readings, pose, condition, clearance.

        Parameters
        ----------
        frame
            The frame in which poses are expressed.
        """
        if not len(self.t):
            return []
        R, T = frame.from_platform(self.R, self.T)
        keys = ("t", *self.columns, *POSE, "condition")
        # Those of cranks and slides take long: they are computed if they are asked for.
        known = self.drives is None or bool(self.clearances.any())
        clearances = [self.clearances] if known else []
        keys += ("clearance",) * len(clearances)
        gaps = [] if self.gaps is None else [self.gaps]
        keys += ("gap",) * len(gaps)
        numbers = np.column_stack(
            (
                self.t,
                self._readings(),
                T,
                continuous_quaternions(R[None])[0],
                printed_conditions(self.conditions),
                *clearances,
                *gaps,
            )
        )
        return [dict(zip(keys, row, strict=True)) for row in numbers.tolist()]

    def to_json(self, frame: PoseFrame = IDENTITY) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.path/1``.

        Parameters
        ----------
        frame
            The frame in which poses are expressed.
        """
        return {
            "schema": "gsp.path/1",
            **self.instance.to_json(),
            **({} if frame.is_identity else {"frames": frame.to_json()}),
            "from": self.start,
            "to": self.goal,
            "verdict": self.verdict,
            "reason": self.reason or None,
            "along": self.along or None,
            "length": self.length,
            "straight_length": self.straight_length,
            **({} if self.timing is None else {"timing": self.timing.to_json()}),
            "parts": [part.to_json() for part in self.parts],
            "rows": self.rows(frame),
        }


def steps(instance: Instance, R: Array, T: Array) -> Array:
    """Return how far the points of the platform move from row to row, shape (r - 1,).

    Root mean squares, in the unit of length; 0 where the poses differ by rounding errors only.
    """
    places = _places(instance, R, T)
    moved = np.sqrt((np.diff(places, axis=0) ** 2).sum(axis=2).mean(axis=1))
    return np.where(moved > _STILL * Arrangement.of(instance).length, moved, 0.0)


def cost(instance: Instance, R: Array, T: Array, power: float = 1.0) -> float:
    """Return the integral of a power of the condition number by the length of a path, in lengths.

    Parameters
    ----------
    instance
        The platform.
    R, T
        Poses along the path, shapes (r, 3, 3) and (r, 3).
    power
        Of the condition number; with 0 the cost is the length.
    """
    a = Arrangement.of(instance)
    regular = 1 / condition_numbers(Machine.of(instance).placed(R, T), R, T)
    if not regular.all():
        return np.inf
    # The harmonic mean between rows: 1 / condition is nearly linear.
    mean = 2 / (regular[1:] + regular[:-1])
    return float((steps(instance, R, T) * mean**power).sum() / a.length)


class WayCosts:
    """Estimated costs of ways between nodes, by the poses at their ends."""

    def __init__(self, instance: Instance) -> None:
        self.instance = instance
        self._arrangement = Arrangement.of(instance)
        self._places: list[Array] = []
        self._regular: list[float] = []

    def add(self, R: Array, T: Array) -> None:
        """Add nodes, shapes (n, 3, 3) and (n, 3)."""
        self._places += [*_places(self.instance, R, T)]
        conditions = condition_numbers(Machine.of(self.instance).placed(R, T), R, T)
        self._regular += (1 / conditions).tolist()

    def between(self, i: int, j: int) -> float:
        """Return the cost of a way between two nodes."""
        moved = self._places[j] - self._places[i]
        length = float(np.sqrt((moved**2).sum(axis=1).mean())) / self._arrangement.length
        return round(2 * length / max(self._regular[i] + self._regular[j], 1e-12), _DECIMALS)


def _places(instance: Instance, R: Array, T: Array) -> Array:
    """Return the points of the platform that count at poses, shape (n, m, 3)."""
    a = Arrangement.of(instance)
    own = a.y[a.distances] if len(a.distances) else a.y
    places: Array = own @ np.swapaxes(R, -1, -2) + T[:, None]
    return places
