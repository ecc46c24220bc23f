"""What a solve returns: every pose found and an account of every path."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.catalogue.kinds import DLL
from gspcli.continuation.paths import PathAccount, Verdict
from gspcli.defaults import PATIENCE
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import euler_from_rotation, named_order
from gspcli.geometry.home_mode import HomeMode, home_among, home_mode
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import LeftLimit, left_limits, restricts
from gspcli.geometry.measurement import (
    condition_numbers,
    known_sides,
    printed_condition,
    printed_conditions,
    printed_residual,
    printed_residuals,
    proved_residuals,
    residuals,
)
from gspcli.geometry.quaternions import Field, quaternion_from_rotation, vector_from_rotation
from gspcli.records import EqualByContent, dataclass
from gspcli.solver.poses import CountKind, PoseSet

if TYPE_CHECKING:
    import pandas as pd

    from gspcli.geometry.frames import PoseFrame


@dataclass(frozen=True)
class Counts:
    """How many poses of which sort."""

    #: Distinct finite isolated solutions.
    found: int
    #: How many of those are real, are certified, have a multiplicity above one.
    real: int
    certified: int
    singular: int


@dataclass(frozen=True, eq=False)
class Solution(EqualByContent):
    """One pose."""

    #: From 1 in the order of the result, as `gsp solve` and its CSV have it.
    number: int
    #: Whether the pose is real, and whether that and its existence are proved.
    real: bool
    certified: bool
    #: How many paths end at it.
    multiplicity: int
    #: Rotation (3, 3) and translation (3,), complex for a pose that is not real.
    R: Field
    T: Field
    #: Of the rotation, scalar first, ``e.e = 1``, shape (4,).
    quaternion: Field
    #: The largest difference between what a constraint measures and its value, in the units of the
    #: instance (lengths and angles alike).
    residual: float
    #: Condition number of the pose (`gspcli.geometry.measurement.condition_numbers`).
    condition: float
    #: For each DPH and DHP constraint, by its number from 1: ``positive`` or ``negative``. Without
    #: those at a height of zero, or whose sign neither doubles nor a proof tells.
    sides: Mapping[int, str]
    #: The ranges and cones that the pose does not keep; None if it is not real, or the instance has
    #: none.
    limits: tuple[LeftLimit, ...] | None = None
    #: Whether it is the home mode (`gspcli.geometry.home_mode`).
    home: bool = False

    def __repr__(self) -> str:
        sort = ("real" if self.real else "complex") + ", certified" * self.certified
        size = f"residual {self.residual:.1e}, condition {self.condition:.4g}"
        return f"<Solution: {sort}, {size}, T {np.array2string(self.T, precision=6)}>"

    def to_json(self, length: float = 0.0) -> dict[str, Any]:
        """Return the pose as plain data (see `SolveResult.to_json`).

        Parameters
        ----------
        length
            Of the platform: the residual is written up to the rounding errors of this length.
        """
        document: dict[str, Any] = {
            "number": self.number,
            "real": self.real,
            "certified": self.certified,
            "home": self.home,
            "multiplicity": self.multiplicity,
            "R": self.R.real.tolist(),
            "T": self.T.real.tolist(),
            "quaternion": self.quaternion.real.tolist(),
            "residual": printed_residual(self.residual, length),
            "condition": printed_condition(self.condition) if np.isfinite(self.condition) else None,
            "sides": {str(number): side for number, side in self.sides.items()},
        }
        if self.limits is not None:
            document["limits"] = [limit.to_json() for limit in self.limits]
        if not self.real:
            document["R_imag"] = self.R.imag.tolist()
            document["T_imag"] = self.T.imag.tolist()
            document["quaternion_imag"] = self.quaternion.imag.tolist()
        return document


Reader = Callable[["SolveResult"], Sequence[Any] | NDArray[Any]]
#: How rotations can be written besides as Euler angles, which are named by their axes.
ROTATIONS = ("quaternion", "matrix", "rotvec")


@dataclass(frozen=True)
class PoseColumn:
    """A column: one entry for every pose."""

    #: The name of the column in every format.
    key: str
    #: Takes the values from a result, one for each pose.
    read: Reader
    #: Which unit of the instance the values are in.
    unit: Literal["", "length", "angle"] = ""
    #: Whether it is a part of the pose itself, complex where the pose is not real.
    of_pose: bool = False


def _part(read: Callable[[SolveResult], NDArray[Any]], entry: int) -> Reader:
    """Read one of the entries that there are for each pose."""
    return lambda result: read(result)[:, entry]


def _sides(result: SolveResult) -> list[list[str]]:
    return [
        [f"{constraint}:{side}" for constraint, side in solution.sides.items()]
        for solution in result.solutions
    ]


#: The position of the platform's origin in the base.
TRANSLATION = tuple(
    PoseColumn(f"T{axis}", _part(lambda r: r.T, k), "length", of_pose=True)
    for k, axis in enumerate("xyz")
)
QUATERNION = tuple(
    PoseColumn(f"q{axis}", _part(lambda r: r.quaternions, k), of_pose=True)
    for k, axis in enumerate("wxyz")
)
_MATRIX = tuple(
    PoseColumn(f"r{i + 1}{j + 1}", _part(lambda r: r.R.reshape(-1, 9), 3 * i + j), of_pose=True)
    for i in range(3)
    for j in range(3)
)
#: What is known of the pose.
FACTS = (
    PoseColumn("real", lambda r: r.real),
    PoseColumn("sides", _sides),
    PoseColumn("multiplicity", lambda r: r.multiplicity),
    PoseColumn(
        "residual",
        lambda r: printed_residuals(r.residuals.max(axis=1, initial=0.0), r.arrangement.length),
    ),
    PoseColumn("condition", lambda r: printed_conditions(r.conditions)),
    PoseColumn("certified", lambda r: r.certified),
    PoseColumn("home", lambda r: [solution.home for solution in r.solutions]),
)
#: The order is that of the CSV, after the number, and of the frame.
COLUMNS = (*TRANSLATION, *QUATERNION, *FACTS)


def expressed(
    frame: PoseFrame, arrangement: Arrangement, R: Field, T: Field, real: NDArray[np.bool_]
) -> SolveResult:
    """Return poses as they are expressed in a frame, with what `rotation_columns` read of them."""
    R, T = frame.from_platform(R, T)
    quaternions = quaternion_from_rotation(R)
    given = {"arrangement": arrangement, "R": R, "T": T, "quaternions": quaternions, "real": real}
    return cast("SolveResult", SimpleNamespace(**given))


def expressed_columns(columns: Sequence[PoseColumn], frame: PoseFrame) -> Sequence[PoseColumn]:
    """Return columns of poses as they are expressed in a frame; positions are x, y and z then."""
    if frame.is_identity:
        return columns
    return [
        replace(
            column, key=column.key.removeprefix("T"), read=partial(_expressed, column.read, frame)
        )
        for column in columns
    ]


def _expressed(read: Reader, frame: PoseFrame, result: SolveResult) -> Sequence[Any] | NDArray[Any]:
    return read(expressed(frame, result.arrangement, result.R, result.T, result.real))


def rotation_columns(form: str) -> tuple[PoseColumn, ...]:
    """Return the columns of rotations written in a form.

    Parameters
    ----------
    form
        One of `ROTATIONS`, or three axes as `gspcli.geometry.euler` takes them: ``ZYX`` for
        turns about the axes of the platform, ``xyz`` about those of the base; or the name of a
        maker, ``PI``, ``LinuxCNC``, ``Symetrie``. Vectors and
        angles are in the angle unit of the instance, and say nothing of poses that are not real.

    Raises
    ------
    GspError
        If it is no such form.
    """
    known = {"quaternion": QUATERNION, "matrix": _MATRIX}
    if form in known:
        return known[form]
    if form == "rotvec":
        return tuple(
            PoseColumn(f"rotvec_{axis}", _part(_vectors, k), "angle", of_pose=True)
            for k, axis in enumerate("xyz")
        )
    try:
        sequence = named_order(form)
    except GspError as error:
        raise GspError(f"{error}\nor one of {', '.join(ROTATIONS)}") from error
    return tuple(
        PoseColumn(f"r{axis}", _part(partial(_angles, sequence), k), "angle", of_pose=True)
        for k, axis in enumerate("xyz")
    )


def _vectors(result: SolveResult) -> NDArray[np.float64]:
    return _of_real(result, vector_from_rotation)


def _angles(sequence: str, result: SolveResult) -> NDArray[np.float64]:
    return _of_real(result, partial(euler_from_rotation, sequence))


def _of_real(
    result: SolveResult, written: Callable[[NDArray[np.float64]], NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Return angles of the real poses in the unit of the instance, others are not numbers."""
    values = np.full((len(result.R), 3), np.nan)
    values[result.real] = written(result.R[result.real].real) / result.arrangement.in_radians
    return values


def plain_table(result: SolveResult, account: str) -> str:
    """Return the real poses as a table of plain text, with the account of paths below it."""
    units = {
        "length": f" [{result.instance.units.length}]",
        "angle": f" [{result.instance.units.angle.value}]",
        "": "",
    }
    count = int(result.real.sum())
    columns: list[list[str]] = [["no.", *(str(k + 1) for k in range(count))]]
    for column in COLUMNS:
        values = [_text(value) for value in column.read(result)[:count]]
        # A column with the usual value for all poses is left out.
        if not set(values) <= {"True", "1", ""}:
            columns.append([column.key + units[column.unit], *values])
    widths = [max(map(len, cells)) for cells in columns]
    rows = [
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        for row in zip(*columns, strict=True)
    ]
    name = result.instance.title
    return "\n".join([name, *(rows if count else ()), account])


def _text(value: Any) -> str:
    if isinstance(value, list):
        return " ".join(value)
    return f"{np.real(value):.6g}" if isinstance(value, float | complex) else str(value)


Array = NDArray[np.float64]
SCHEMA = "gsp.solve/1"


@dataclass(frozen=True, eq=False, kw_only=True)
class SolveResult(PoseSet):
    """All poses of an instance.

    The order of the poses does not depend on how they were found (`stable_order`); the first
    component of their quaternions that is not zero is positive.

    Attributes
    ----------
    instance, arrangement
        What was solved, as given and in floating point.
    seed
        The source of random choices.
    left_out
        Indices of real poses of which none can be home.
    """

    instance: Instance
    arrangement: Arrangement
    seed: int
    left_out: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        for array in self.arrays().values():
            array.setflags(write=False)

    def __repr__(self) -> str:
        name = self.instance.name or self.instance.type.id
        return f"<SolveResult of {name}: {self.account_text}>"

    def __str__(self) -> str:
        return plain_table(self, self.account_text)

    @property
    def lone(self) -> SolveResult:
        """The same platform with the real poses from which no real motion begins, as its poses."""
        motions = [motion for motion in self.motions if not motion.dimension]
        count = len(motions)
        R = np.concatenate([np.zeros((0, 3, 3)), *(motion.R for motion in motions)])
        T = np.concatenate([np.zeros((0, 3)), *(motion.T for motion in motions)])
        poses = PoseSet(
            quaternions=quaternion_from_rotation(R).astype(complex),
            R=R.astype(complex),
            T=T.astype(complex),
            real=np.ones(count, bool),
            certified=np.zeros(count, bool),
            multiplicity=np.ones(count, int),
            account=PathAccount(expected=count, found=count),
        )
        return replace(self, **vars(poses.in_order(self.arrangement.length)))

    @property
    def drawn(self) -> SolveResult:
        """What there is to look at: itself, or `lone` if no real pose is isolated."""
        return self if self.counts.real else self.lone

    @cached_property
    def home(self) -> HomeMode | None:
        """Which of the real poses of `drawn` is home (`home_mode`); None if there are none."""
        real = self.drawn.real
        R, T = self.drawn.R[real].real, self.drawn.T[real].real
        if not self.left_out or not self.counts.real:
            return home_mode(self.instance, R, T)
        return home_among(self.instance, R, T, [k for k in range(len(R)) if k not in self.left_out])

    @property
    def expected(self) -> int:
        """The generic count for the sides asked for."""
        return self.account.expected

    @property
    def verdict(self) -> Verdict:
        """`infinite`, `incomplete` or `complete`, as the account says."""
        return self.account.verdict

    @cached_property
    def geometry_count(self) -> int | None:
        """How many poses this geometry has for almost all values; None if it was not counted.

        Lines at distance zero have one sign, as in `expected`: for other values they have two. It
        is computed when it is asked for, except where the poses prove it to be the type's.
        """
        if self.proof is not None and self.proof.by is CountKind.TYPE:
            return self.expected
        if self.proof is not None and self.proof.by is CountKind.GEOMETRY:
            return len(self.R)
        if self.exact_count is None and self.verdict != "infinite":
            return None
        from gspcli.certification.counting import geometry_count
        from gspcli.solver.solved_starts import STARTS

        # Distances of zero leave no sides to choose, and are no values in general position.
        known = None
        if self.arrangement.values[self.arrangement.distances].all():
            known = STARTS.count(self.instance, self.arrangement.values, self.seed, PATIENCE)
        count = known or geometry_count(self.instance, seed=self.seed)
        zeros = sum(row.kind is DLL and row.value.value == 0 for row in self.instance.constraints)
        return None if count is None or count.solutions is None else count.solutions >> zeros

    @cached_property
    def counts(self) -> Counts:
        """How many poses there are of which sort."""
        return Counts(
            found=len(self.R),
            real=int(self.real.sum()),
            certified=int(self.certified.sum()),
            singular=int((self.multiplicity > 1).sum()),
        )

    @cached_property
    def residuals(self) -> Array:
        """Residual of each constraint at each pose, units of the instance, shape (n, 6)."""
        R, T, real = self.R, self.T, self.real
        found = np.empty((len(R), 6))
        for measure, chosen in ((proved_residuals, self.certified), (residuals, ~self.certified)):
            at, off = real & chosen, ~real & chosen
            found[at] = measure(self.arrangement, R[at].real, T[at].real)
            found[off] = measure(self.arrangement, R[off], T[off])
        return found

    @cached_property
    def conditions(self) -> Array:
        """Condition number of each pose, shape (n,)."""
        return condition_numbers(self.arrangement, self.R, self.T)

    @cached_property
    def sides(self) -> NDArray[np.int64]:
        """On which side of each plane: 1, -1, or 0 if that is not known, shape (n, 6)."""
        sides = known_sides(self.arrangement, self.R, self.T)
        if self.signs is None:
            return sides
        proved = self.arrangement.sided & (self.arrangement.targets != 0)
        return np.where((sides == 0) & proved, self.signs, sides).astype(int)

    @cached_property
    def solutions(self) -> tuple[Solution, ...]:
        """The poses one by one."""
        quaternions = self.quaternions
        sides = self.sides
        names = {1: Side.POSITIVE.value, -1: Side.NEGATIVE.value}
        limits = self._limits()
        home = self.home.number if self.home and self.counts.real else None
        return tuple(
            Solution(
                number=k + 1,
                real=bool(self.real[k]),
                certified=bool(self.certified[k]),
                multiplicity=int(self.multiplicity[k]),
                R=self.R[k].real if self.real[k] else self.R[k],
                T=self.T[k].real if self.real[k] else self.T[k],
                quaternion=quaternions[k].real if self.real[k] else quaternions[k],
                residual=float(self.residuals[k].max()),
                condition=float(self.conditions[k]),
                sides={i + 1: names[s] for i, s in enumerate(sides[k].tolist()) if s},
                limits=limits.get(k),
                home=k + 1 == home,
            )
            for k in range(len(self.R))
        )

    def _limits(self) -> dict[int, tuple[LeftLimit, ...]]:
        """Return the limits that real poses do not keep, by their indices, if there are any."""
        if not restricts(self.instance):
            return {}
        real = np.flatnonzero(self.real)
        values = self.arrangement.values * np.where(self.sides[real] < 0, -1.0, 1.0)
        found = left_limits(self.instance, values, self.R[real].real, self.T[real].real)
        return dict(zip(real.tolist(), found, strict=True))

    @property
    def real_R(self) -> NDArray[np.float64]:
        """The rotations of the real poses, real, shape (n, 3, 3)."""
        return self.R[self.real].real

    @property
    def real_T(self) -> NDArray[np.float64]:
        """The translations of the real poses, real, shape (n, 3)."""
        return self.T[self.real].real

    @property
    def real_solutions(self) -> tuple[Solution, ...]:
        """The real poses: the assembly modes."""
        return self.solutions[: self.counts.real]

    def to_json(self, *, everything: bool = False) -> dict[str, Any]:
        """Return the result as plain data of schema ``gsp.solve/1``.

        Parameters
        ----------
        everything
            Whether poses that are not real are included.
        """
        chosen = self.solutions if everything else self.real_solutions
        document: dict[str, Any] = {
            "schema": SCHEMA,
            **self.instance.to_json(),
            "expected": self.expected,
            "verdict": self.verdict,
            "proof": self.proof.to_json() if self.proof else None,
            "geometry_count": self.geometry_count,
            "exact_count": self.exact_count,
            "counts": self._counts_json(),
            "home": None if self.home is None else self.home.to_json(),
            "solutions": [solution.to_json(self.arrangement.length) for solution in chosen],
        }
        if self.motions:
            document["motions"] = [motion.to_json() for motion in self.motions]
        return {**document, "seed": self.seed, "version": __version__}

    def _counts_json(self) -> dict[str, int]:
        account = self.account
        return {
            **vars(self.counts),
            "at_infinity": account.at_infinity,
            "on_curves": account.on_curves,
            "spurious": account.spurious,
            "lost": account.lost,
        }

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the poses to look at (`gspcli.notebook_view`)."""
        # Pictures are in a room above this one: only the package itself imports them.
        from gspcli import notebook_view

        return notebook_view(self)

    def to_frame(self, *, everything: bool = False) -> pd.DataFrame:
        """Return the poses as a table with a row for each (pandas is imported now).

        The columns are those of `gspcli.solver.result`, as in the CSV of `gsp solve`; the
        index is the number, from 1. With ``everything`` the quaternions and translations are
        complex.
        """
        import pandas as pd

        count = len(self.R) if everything else self.counts.real
        data: dict[str, Any] = {}
        for column in COLUMNS:
            values = column.read(self)[:count]
            data[column.key] = np.real(values) if column.of_pose and not everything else values
        return pd.DataFrame(data, index=pd.RangeIndex(1, count + 1, name="number"))
