"""The columns of poses, one line each, for tables, CSV and frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import GspError
from gspcli.geometry.euler import euler_from_rotation, named_order
from gspcli.geometry.printed_numbers import printed_conditions, printed_residuals
from gspcli.geometry.quaternions import quaternion_from_rotation, vector_from_rotation
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.geometry.arrangement import Arrangement
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.geometry.quaternions import Field
    from gspcli.solver.results.solution import Solution


class PosesOfColumns(Protocol):
    """Poses of which something is said, and of what they are: a `SolveResult`."""

    @property
    def instance(self) -> Instance:
        """The platform."""

    @property
    def arrangement(self) -> Arrangement:
        """The platform in floating point."""

    @property
    def R(self) -> Field:
        """Rotations, shape (n, 3, 3)."""

    @property
    def T(self) -> Field:
        """Translations, shape (n, 3)."""

    @property
    def quaternions(self) -> Field:
        """Unit quaternions, shape (n, 4)."""

    @property
    def real(self) -> NDArray[np.bool_]:
        """Which are real, the first ones, shape (n,)."""

    @property
    def certified(self) -> NDArray[np.bool_]:
        """Which are certified, shape (n,)."""

    @property
    def multiplicity(self) -> NDArray[np.int64]:
        """The multiplicity of each, shape (n,)."""

    @property
    def residuals(self) -> NDArray[np.float64]:
        """The residual of each constraint, shape (n, 6)."""

    @property
    def conditions(self) -> NDArray[np.float64]:
        """Condition numbers, shape (n,)."""

    @property
    def solutions(self) -> tuple[Solution, ...]:
        """The poses one by one."""


Reader = Callable[[PosesOfColumns], Sequence[Any] | NDArray[Any]]
#: How rotations can be written besides as Euler angles, which are named by their axes.
ROTATIONS = ("quaternion", "matrix", "rotvec")


@dataclass(frozen=True)
class PoseColumn:
    """A column: one entry for every pose.

    Attributes
    ----------
    key
        The name of the column in every format.
    read
        Takes the values from a result, one for each pose.
    unit
        Which unit of the instance the values are in.
    of_pose
        Whether it is a part of the pose itself, complex where the pose is not real.
    """

    key: str
    read: Reader
    unit: Literal["", "length", "angle"] = ""
    of_pose: bool = False


def _part(read: Callable[[PosesOfColumns], NDArray[Any]], entry: int) -> Reader:
    """Read one of the entries that there are for each pose."""
    return lambda result: read(result)[:, entry]


def _sides(result: PosesOfColumns) -> list[list[str]]:
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
) -> PosesOfColumns:
    """Return poses as they are expressed in a frame, with what `rotation_columns` read of them."""
    R, T = frame.from_platform(R, T)
    quaternions = quaternion_from_rotation(R)
    given = {"arrangement": arrangement, "R": R, "T": T, "quaternions": quaternions, "real": real}
    return cast("PosesOfColumns", SimpleNamespace(**given))


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


def _expressed(
    read: Reader, frame: PoseFrame, result: PosesOfColumns
) -> Sequence[Any] | NDArray[Any]:
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
        message = f"{error}\nor one of {', '.join(ROTATIONS)}"
        raise GspError(message) from error
    return tuple(
        PoseColumn(f"r{axis}", _part(partial(_angles, sequence), k), "angle", of_pose=True)
        for k, axis in enumerate("xyz")
    )


def _vectors(result: PosesOfColumns) -> NDArray[np.float64]:
    return _of_real(result, vector_from_rotation)


def _angles(sequence: str, result: PosesOfColumns) -> NDArray[np.float64]:
    return _of_real(result, partial(euler_from_rotation, sequence))


def _of_real(
    result: PosesOfColumns, written: Callable[[NDArray[np.float64]], NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Return angles of the real poses in the unit of the instance, others are not numbers."""
    values = np.full((len(result.R), 3), np.nan)
    values[result.real] = written(result.R[result.real].real) / result.arrangement.in_radians
    return values


def plain_table(result: PosesOfColumns, account: str) -> str:
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
