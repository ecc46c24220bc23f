"""The tables of `gsp solve`: one of poses, or orientations and the positions in each."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gspcli.catalogue.types import MAX_ANGLES
from gspcli.cli.digits import DECIMALS
from gspcli.cli.output import Column, Table
from gspcli.cli.summary import proved
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.printed_numbers import printed_residual
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.records import dataclass
from gspcli.solver.results.columns import FACTS, TRANSLATION, PoseColumn, expressed_columns

if TYPE_CHECKING:
    from gspcli.solver import SolveResult

#: Parts of a pose smaller than this are shown as zero, lengths by the platform's.
_ZERO = 1e-12
#: Components of quaternions that differ by less are of one orientation.
_SAME = 1e-9
_NUMBER = PoseColumn("number", lambda result: range(1, len(result.R) + 1))
LEGEND = (
    "Tx Ty Tz: the origin of the platform in the base, x_base = R x_platform + T",
    "qw qx qy qz: the unit quaternion of R, scalar first; rx ry rz: the angles about these axes",
    "condition: the largest over the smallest change of the pose for equal changes of the values; "
    "infinite if it is singular",
    "sides: + where the point is on the side to which the normal points, - on the other",
    "remarks: whether a pose is not real, not simple or not proved",
    "home: the mode that commands use by default",
)


@dataclass(frozen=True)
class Shown:
    """Which poses are shown, and how.

    Attributes
    ----------
    indices
        The poses in the order of the table.
    rotation
        The columns of the rotations.
    decimals
        Decimals of positions and rotations; None for as many as fit.
    distances
        For each pose of the table its distance from the pose of ``--near``: the translation and the
        angle, in the units of the instance; None without the option.
    fits
        For each real pose the deviations of the readings, and whether it fits them
        (`gspcli.sensing.ReadingFit.rows`); None if there are no readings.
    frame
        The frame in which poses are expressed.
    left
        The numbers of the real poses that are left out, by reasons; None if all are shown.
    """

    indices: Sequence[int]
    rotation: Sequence[PoseColumn]
    decimals: int | None = None
    distances: Sequence[tuple[float, float]] | None = None
    fits: Sequence[Mapping[str, Any]] | None = None
    frame: PoseFrame = IDENTITY
    left: Mapping[str, list[int]] | None = None

    def left_sentences(self, result: SolveResult) -> list[str]:
        """Return the sentence about real poses that are omitted, if a filter is given."""
        if self.left is None:
            return []
        from gspcli.motion.poses.mode_filters import left_out_sentence

        return [left_out_sentence(self.left, result.counts.real)]

    @property
    def position(self) -> Sequence[PoseColumn]:
        """The columns of positions."""
        return expressed_columns(TRANSLATION, self.frame)

    @property
    def turns(self) -> Sequence[PoseColumn]:
        """The columns of rotations, as they are expressed."""
        return expressed_columns(self.rotation, self.frame)

    @property
    def numbers(self) -> list[int]:
        """The numbers of the poses, from 1."""
        return [index + 1 for index in self.indices]


def data_table(
    result: SolveResult,
    shown: Shown,
    digits: Sequence[Mapping[str, str]],
    *,
    imaginary: bool,
    summary: Sequence[str],
) -> Table:
    """Return every column of the poses, for programs."""
    columns = [_NUMBER, *shown.position, *shown.turns, *FACTS]
    read = {column.key: column.read(result) for column in columns}
    rows: list[dict[str, Any]] = []
    for index in shown.indices:
        row = {key: _plain(values[index]) for key, values in read.items()}
        rows.append({key: _real(value) for key, value in row.items()})
        if not result.real[index]:
            rows[-1] |= {
                f"{key}_imag": value.imag
                for key, value in row.items()
                if isinstance(value, complex)
            }
    for row, (length, angle) in zip(rows, shown.distances or (), strict=False):
        row |= {"distance": length, "turn": angle}
    for row, index in zip(rows, shown.indices, strict=True):
        row |= _fit_of(result, shown, index)
    for row, decimals in zip(rows, digits, strict=False):
        row |= decimals
    keys = [column.key for column in columns]
    if shown.distances is not None:
        keys += ["distance", "turn"]
    if shown.fits is not None:
        keys += ["off", "fits"]
    if imaginary:
        keys += [f"{c.key}_imag" for c in columns if c.of_pose]
    keys += [key for key in DECIMALS if any(key in row for row in rows)]
    return Table([Column(key) for key in keys], rows, summary=summary, part="poses")


def add_expressed(document: dict[str, Any], result: SolveResult, shown: Shown) -> None:
    """Add to a document how its real poses are expressed; R and T are unchanged."""
    document["frames"] = shown.frame.to_json()
    entries = document["solutions"]
    for k in shown.indices:
        if result.real[k]:
            R, T = shown.frame.from_platform(result.R[k].real, result.T[k].real)
            expressed = {"position": T.tolist(), "quaternion": quaternion_from_rotation(R).tolist()}
            entries[k]["expressed"] = expressed


def pose_tables(
    result: SolveResult,
    shown: Shown,
    *,
    summary: Sequence[str],
    notes: Sequence[str],
) -> list[Table]:
    """Return the poses for people: units in the headings, exceptions marked."""
    instance = result.instance
    title = instance.title
    if not shown.indices:
        return [Table([], [], title, notes=notes, summary=summary)]
    rows = _rows(result, shown)
    number = Column("number", "no.", align="right", essential=True)
    translation = [_column(result, column, shown) for column in shown.position]
    rotation = [_column(result, column, shown) for column in shown.turns]
    units = instance.units
    last = [
        Column("distance", f"distance [{units.length}]", "right", minor=1, aligned=True),
        Column("turn", f"turn [{units.angle.value}]", "right", minor=1, aligned=True),
        Column("off", "off [σ]", "right", minor=1),
        Column("sides", _sided(result), minor=1),
        Column("residual", align="right", minor=3),
        Column("condition", align="right", minor=2),
        Column("remarks", minor=-1, fold=", "),
    ]
    last = [column for column in last if any(row.get(column.key) is not None for row in rows)]
    orientations = _orientations(result, shown)
    if not orientations:
        columns = [number, *translation, *rotation, *last]
        return [Table(columns, rows, title, notes=notes, summary=summary, part="poses")]
    named = {k: letter for letter, group in orientations.items() for k in group}
    for row in rows:
        row["orientation"] = named[row["number"] - 1]
    leaders = [
        {
            **next(row for row in rows if row["number"] == group[0] + 1),
            "orientation": letter,
            "positions": len(group),
        }
        for letter, group in orientations.items()
    ]
    orientation = Column("orientation", essential=True)
    positions = Column("positions", align="right", essential=True)
    return [
        Table([orientation, *rotation, positions], leaders, title, (), summary, "orientations"),
        Table([number, orientation, *translation, *last], rows, notes=notes, part="poses"),
    ]


def lone_tables(result: SolveResult, shown: Shown) -> list[Table]:
    """Return the real poses that are isolated over the real but not over the complex numbers."""
    alone = replace(shown, indices=range(len(result.lone.R)), distances=None)
    if not alone.indices:
        return []
    notes = [
        "none of these real poses can move, and there are no others: known by exact counts. That "
        "all constraints hold there is checked to 50 decimals; to 9 where poses meet, and for the "
        "distance of parallel lines"
    ]
    tables = pose_tables(result.lone, alone, summary=[], notes=notes)
    # As equations over the complex numbers the constraints are singular there.
    left_out = ("condition", "residual")
    return [
        replace(
            table, title="real poses", columns=[c for c in table.columns if c.key not in left_out]
        )
        for table in tables
    ]


def _rows(result: SolveResult, shown: Shown) -> list[dict[str, Any]]:
    pose = {column.key: column.read(result) for column in (*shown.position, *shown.turns)}
    smallest = {column.key: _ZERO * result.arrangement.length for column in shown.position}
    known = proved(result)
    constant = len({tuple(s.sides.items()) for s in result.solutions}) == 1
    rows = []
    for place, index in enumerate(shown.indices):
        solution = result.solutions[index]
        row: dict[str, Any] = {
            key: _rounded(_plain(values[index]), smallest.get(key, _ZERO))
            for key, values in pose.items()
        }
        row["number"] = index + 1
        row["condition"] = float(f"{solution.condition:.3g}")
        if solution.sides and (not constant or not _fixed_sides(result)):
            row["sides"] = "".join("+" if s == "positive" else "-" for s in solution.sides.values())
        if not known[index]:
            row["residual"] = printed_residual(solution.residual, result.arrangement.length)
        remarks = ["home"] if solution.home else []
        remarks += ["nearest"] if shown.distances is not None and place == 0 else []
        fit = _fit_of(result, shown, index)
        if fit:
            row["off"] = float(f"{fit['off']:.3g}")
        remarks += ["fits"] if fit.get("fits") else []
        remarks += [] if solution.real else ["not real"]
        if solution.multiplicity > 1:
            many = solution.multiplicity
            remarks.append("double" if many == 2 else f"multiplicity {many}")
        if not known[index] and known.any():
            remarks.append("not proved")
        row["remarks"] = ", ".join(remarks) or None
        if shown.distances is not None:
            row["distance"], row["turn"] = shown.distances[place]
        rows.append(row)
    return rows


def _fit_of(result: SolveResult, shown: Shown, index: int) -> dict[str, Any]:
    """Return how the readings fit a pose; nothing without readings, or if it is not real."""
    if shown.fits is None or not result.real[index] or index >= len(shown.fits):
        return {}
    return {key: shown.fits[index][key] for key in ("off", "fits")}


def _fixed_sides(result: SolveResult) -> bool:
    """Return whether the file states all sides, so that they are the same at all poses."""
    return bool((result.arrangement.signs != 0)[result.arrangement.sided].all())


def _sided(result: SolveResult) -> str:
    sided = np.flatnonzero(result.arrangement.sided) + 1
    return f"sides {','.join(map(str, sided))}"


def _column(result: SolveResult, column: PoseColumn, shown: Shown) -> Column:
    units = result.instance.units
    unit = {"length": units.length, "angle": units.angle.value, "": ""}[column.unit]
    heading = f"{column.key} [{unit}]" if unit else column.key
    return Column(
        column.key, heading, "right", essential=True, aligned=True, decimals=shown.decimals
    )


def _orientations(result: SolveResult, shown: Shown) -> dict[str, list[int]]:
    """Return the poses by orientation, which three angles determine; empty if it is no help."""
    if len(result.arrangement.angles) != MAX_ANGLES or shown.distances is not None:
        return {}
    if not result.real[list(shown.indices)].all():
        return {}
    groups: list[list[int]] = []
    for index in shown.indices:
        q = result.quaternions[index]
        if groups and np.abs(q - result.quaternions[groups[-1][0]]).max() < _SAME:
            groups[-1].append(index)
        else:
            groups.append([index])
    if len(groups) == len(shown.indices):
        return {}
    return dict(zip(_letters(), groups, strict=False))


def _letters() -> itertools.chain[str]:
    alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    return itertools.chain(alphabet, map("".join, itertools.product(alphabet, repeat=2)))


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _real(value: Any) -> Any:
    return value.real if isinstance(value, complex) else value


def _rounded(value: Any, smallest: float) -> float | complex:
    """Return a number with rounding errors about zero taken away, real if it is."""
    number = complex(value)
    parts = [part if abs(part) > smallest else 0.0 for part in (number.real, number.imag)]
    return parts[0] if parts[1] == 0 else complex(*parts)
