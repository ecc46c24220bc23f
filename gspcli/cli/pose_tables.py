"""The tables of `gsp solve`: one of poses, or orientations and the positions in each."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.cli.result import Field, Fields, Result
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.primitives import Line
from gspcli.geometry.printed_numbers import printed_residual
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.records import dataclass
from gspcli.solver.poses import CountKind
from gspcli.solver.result import FACTS, TRANSLATION, PoseColumn, expressed_columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gspcli.certification import Certificate
    from gspcli.geometry.instance import Instance
    from gspcli.solver import SolveResult

FIELDS = Fields("solve")

#: Parts of a pose smaller than this are shown as zero, lengths by the platform's.
_ZERO = 1e-12
#: Components of quaternions that differ by less are of one orientation.
_SAME = 1e-9
_NUMBER = PoseColumn("number", lambda result: range(1, len(result.R) + 1))


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
) -> Result:
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
    return Result([Field(key) for key in keys], rows, summary=summary, part="poses")


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
) -> list[Result]:
    """Return the poses for people: units in the headings, exceptions marked."""
    instance = result.instance
    title = instance.title
    if not shown.indices:
        return [Result([], [], title, notes=notes, summary=summary)]
    rows = _rows(result, shown)
    number = FIELDS["number"]
    translation = [pose_field(one, instance, shown.decimals) for one in shown.position]
    rotation = [pose_field(one, instance, shown.decimals) for one in shown.turns]
    units = instance.units
    last = [
        FIELDS["distance"].but(title=f"distance [{units.length}]"),
        FIELDS["turn"].but(title=f"turn [{units.angle.value}]"),
        FIELDS["off@2"],
        FIELDS["sides"].but(title=_sided(result)),
        *FIELDS.of("residual condition"),
        FIELDS["remarks@2"],
    ]
    last = [column for column in last if any(row.get(column.key) is not None for row in rows)]
    orientations = _orientations(result, shown)
    if not orientations:
        columns = [number, *translation, *rotation, *last]
        return [Result(columns, rows, title, notes=notes, summary=summary, part="poses")]
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
    orientation = FIELDS["orientation"]
    positions = FIELDS["positions"]
    return [
        Result([orientation, *rotation, positions], leaders, title, (), summary, "orientations"),
        Result([number, orientation, *translation, *last], rows, notes=notes, part="poses"),
    ]


def lone_tables(result: SolveResult, shown: Shown) -> list[Result]:
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


def pose_field(column: PoseColumn, instance: Instance, decimals: int | None) -> Field:
    """Return a column of poses for people, with its unit in the heading."""
    units = {"": "", "length": instance.units.length, "angle": instance.units.angle.value}
    heading = f"{column.key} [{units[column.unit]}]" if column.unit else column.key
    return Field(column.key, heading, "right", essential=True, aligned=True, decimals=decimals)


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


_DIGITS = 3
#: Poses that are this many lengths away are called nearly infinite.
_FAR = 1e5


def summary(result: SolveResult, *, contradicting: Sequence[int] = ()) -> list[str]:
    """Return the result in a sentence: the real poses, what is proved, whether these are all."""
    lines = [f"{_real_words(result)}; {_completeness(result)}"]
    if fixed(result):
        one = result.counts.real == 1
        poses, them = ("the isolated real pose", "it") if one else ("these real poses", "them")
        lines.append(
            f"the platform cannot move from {poses}: the infinitely many others are another "
            f"component, apart from {them}"
        )
    if contradicting:
        lines.append(_reason(result, contradicting))
    return lines


def _real_words(result: SolveResult) -> str:
    real = result.counts.real
    # Those of a motion are real, too, and not counted.
    which = "isolated real" if result.verdict == "infinite" else "real"
    text = f"{real or 'no'} {which} pose{'s' * (real > 1)}"
    if lone := len(result.lone.R):
        return f"{lone} real pose{'s' * (lone > 1)} that cannot move"
    if not result.counts.found:
        return text
    # Without a real pose the certificates of the others prove that.
    known = proved(result)[:real] if real else proved(result)
    if known.all():
        return text + (", all proved different" if real > 1 else ", proved")
    if real == 0:
        return text
    return text + (f", {known.sum()} of them proved" if known.any() else ", not proved")


def fixed(result: SolveResult) -> bool:
    """Return whether poses are infinitely many, and all isolated real ones are proved isolated.

    A simple solution is in no larger set of them: no motion passes through it.
    """
    real = result.counts.real
    return result.verdict == "infinite" and real > 0 and bool(result.certified[:real].all())


def proved(result: SolveResult) -> NDArray[np.bool_]:
    """Return which poses are proved: by certificates, multiple ones by the exact count."""
    counted = result.proof is not None and result.proof.by is CountKind.EXACT
    return result.certified | (counted & (result.multiplicity > 1))


def _completeness(result: SolveResult) -> str:
    """Return the verdict, and how the paths end if not every one ends at a pose."""
    ends, found = result.account, result.counts.found
    verdict = f"{result.verdict}, {result.proof.words}" if result.proof else result.verdict
    if result.verdict == "complete" and found == result.expected:
        return f"{verdict}: all {found} of the type, real or not"
    poses = f"{found} pose{'s' * (found != 1)}, real or not"
    if result.verdict == "infinite":
        isolated = f"{found or 'no'} isolated one{'s' * (found != 1)}"
        where = " over the complex numbers" if len(result.lone.R) else ""
        return (
            f"{verdict}: infinitely many poses{where} and {isolated}; "
            f"the type can have {result.expected}"
        )
    if ends.found != found:
        poses += f", {ends.found} with multiplicities"
    named = {
        "at infinity": ends.at_infinity,
        "on curves": ends.on_curves,
        "where parallel lines have another distance": ends.spurious,
        "lost": ends.lost,
    }
    others = [f"{count} {where}" for where, count in named.items() if count]
    where = "".join(f", {other}" for other in others)
    geometry = result.geometry_count
    if geometry is None:
        return f"{verdict}: {poses}{where}, of the type's {result.expected}"
    # The causes for which the geometry has fewer poses than the type are not listed.
    gone = ends.on_curves + ends.spurious + ends.lost
    if geometry < ends.found:
        # A platform of this geometry with other values has fewer poses.
        return f"{verdict}: {poses}; the type can have {result.expected}"
    whole = f"this geometry's {geometry}; the type can have {result.expected}"
    if geometry == result.expected:
        whole = f"the type's {geometry}"
    return f"{verdict}: {poses}{where if gone else ''}, of {whole}"


def _reason(result: SolveResult, contradicting: Sequence[int]) -> str:
    constraints = result.instance.constraints
    kinds = {constraints[k - 1].kind.is_distance for k in contradicting}
    what = "constraint" if len(kinds) > 1 else "distance" if kinds == {True} else "angle"
    if len(contradicting) == 1:
        return f"no pose was found for {what} {contradicting[0]} alone"
    if len(contradicting) == len(constraints):
        return "any five of the constraints have common poses, all six have none"
    *first, last = map(str, contradicting)
    return (
        f"{what}s {', '.join(first)} and {last} contradict each other: "
        "no pose was found for them without the others"
    )


def remarks(result: SolveResult, numbers: Sequence[int]) -> list[str]:
    """Return notes on the poses shown, whose numbers count from 1."""
    if not numbers:
        return [*_far(result), *_parallel(result), *_ground(result)]
    limits = _limits(result, numbers)
    shown = [number - 1 for number in numbers]
    residual = printed_residual(float(result.residuals[shown].max()), result.arrangement.length)
    notes = [f"residuals at most {residual:.0e}"]
    # Mirrored poses differ in the last digits. Of poses with equal rounded numbers the first is
    # named.
    condition = np.array([float(f"{x:.{_DIGITS}g}") for x in result.conditions[shown]])
    best, worst = int(np.argmin(condition)), int(np.argmax(condition))
    lowest, highest = (f"{condition[k]:.{_DIGITS}g}" for k in (best, worst))
    if len(numbers) > 1 and lowest != highest:
        notes.append(
            f"best conditioned: pose {numbers[best]} ({lowest}); "
            f"worst: pose {numbers[worst]} ({highest})"
        )
    if len(numbers) > 1 and lowest == highest:
        notes.append(f"every pose has condition {lowest}")
    home = [result.home.text] if result.home and result.counts.real else []
    return ["; ".join(notes), *home, *limits, *_far(result), *_parallel(result), *_ground(result)]


def _limits(result: SolveResult, numbers: Sequence[int]) -> list[str]:
    """Say which of the real poses shown are outside the ranges and cones of the machine."""
    left = {number: result.solutions[number - 1].limits for number in numbers}
    ranges = {
        one.constraint for limits in left.values() for one in limits or () if one.kind == "range"
    }
    notes = [
        f"constraint {k + 1} is outside its range: the machine can take none of these poses"
        for k in sorted(ranges)
    ]
    beyond = [n for n, limits in left.items() if any(one.kind == "cone" for one in limits or ())]
    if beyond:
        names = ", ".join(map(str, beyond))
        notes.append(f"a leg leaves the cone of a joint in pose{'s' * (len(beyond) > 1)} {names}")
    beyond = [n for n, limits in left.items() if any(one.kind == "knee" for one in limits or ())]
    if beyond:
        names = ", ".join(map(str, beyond))
        notes.append(
            f"an arm or carriage is on the other side of its dead point than at home in "
            f"pose{'s' * (len(beyond) > 1)} {names}"
        )
    return notes


def _far(result: SolveResult) -> list[str]:
    """Say how many poses are nearly at infinity."""
    arrangement = result.arrangement
    offset = result.R @ arrangement.platform_centre + result.T - arrangement.base_centre
    far = int((np.abs(offset).max(axis=1) > _FAR * arrangement.length).sum())
    if not far:
        return []
    return [
        f"{far} of the {result.counts.found} poses lie beyond {_FAR:.0e} lengths: "
        "caused by rounded coordinates, harmless"
    ]


def _parallel(result: SolveResult) -> list[str]:
    """Say which lines are parallel at all poses, if the poses are complete."""
    if result.verdict != "complete" or not result.account.spurious or not len(result.R):
        return []
    numbers = [
        str(number)
        for number, row in enumerate(result.instance.constraints, 1)
        if isinstance(row.platform, Line) and isinstance(row.base, Line) and row.kind is DLL
        if np.abs(np.cross(result.R @ row.platform.unit, row.base.unit)).max() < PARALLEL_SINE
    ]
    if not numbers:
        return []
    several = len(numbers) > 1
    names = f"s {', '.join(numbers[:-1])} and {numbers[-1]}" if several else f" {numbers[0]}"
    return [
        f"the lines of constraint{names} are parallel at every pose: "
        "a point of one has its distance from the other"
    ]


def _ground(result: SolveResult) -> list[str]:
    """Return that the proof is up to a random prime, in words, if it is."""
    said = "" if result.proof is None else result.proof.reservation
    return [said] if said else []


#: The columns of a refined pose, real parts first.
DECIMALS = tuple(
    f"refined_{name}{suffix}"
    for suffix in ("", "_imag")
    for name in (*(f"R{i}{j}" for i in "123" for j in "123"), "Tx", "Ty", "Tz")
)

digits_option = click.option(
    "--digits",
    type=click.IntRange(1, 100_000),
    metavar="N",
    help="Also print each certified solution to N proved digits.",
)


def refined(instance: Instance, certificate: Certificate, digits: int) -> dict[str, Any]:
    """Return R and T of a certified pose as decimal strings with proved digits, for JSON."""
    from gspcli.certification import refine

    pose = refine(instance, certificate, digits)
    return {
        key: value
        for key in ("R", "T", "R_imag", "T_imag")
        if (value := getattr(pose, key)) is not None
    }


def digit_cells(pose: Mapping[str, Any]) -> dict[str, str]:
    """Return a refined pose by the `DECIMALS` columns; nothing of an empty one."""
    flat = [
        text
        for suffix in ("", "_imag")
        if "R" + suffix in pose
        for text in [*(x for row in pose["R" + suffix] for x in row), *pose["T" + suffix]]
    ]
    return dict(zip(DECIMALS, flat, strict=False))


def digit_table(rows: Sequence[Mapping[str, Any]]) -> Result:
    """Return one number a line, for people: fifty digits do not fit beside each other."""
    lines = [
        {"number": row["number"], "entry": key.removeprefix("refined_"), "value": row[key]}
        for row in rows
        for key in DECIMALS
        if key in row
    ]
    columns = FIELDS.of("number entry value")
    return Result(columns, lines, title="Proved digits", part="digits")
