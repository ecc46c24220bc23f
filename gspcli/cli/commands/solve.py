"""`gsp solve`: every pose of a platform given in a file."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import chain, islice, product
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.cli import options
from gspcli.cli.pose_options import frame_note, near_option, pose_options
from gspcli.cli.render import emit, write
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.specs import spec_source, standard_deviations
from gspcli.cli.streams import progress, say, working
from gspcli.errors import ArgumentError, CheckFailed, GspError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import MAKERS
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.measurement import printed_residual
from gspcli.geometry.primitives import Line
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.records import dataclass
from gspcli.solver.poses import CountKind
from gspcli.solver.result import FACTS, TRANSLATION, expressed, expressed_columns, rotation_columns
from gspcli.wording import counted, listed, named, shown

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gspcli.certification import Certificate
    from gspcli.geometry.instance import Instance
    from gspcli.motion.poses.mode_filters import Condition
    from gspcli.sensing import PoseFit, ReadingFit
    from gspcli.sensing.sensor_kinds import SensorReading
    from gspcli.solver import SolveResult
    from gspcli.solver.result import PoseColumn

FIELDS = Fields("solve")

#: The ends of the names of files with an instance in each line, and the format of such answers.
LINE_SUFFIXES = (".jsonl", ".ndjson")
LINES = "jsonl"
#: This process solves this many instances before it starts others: a start takes as long as solving
#: them.
_HERE_FIRST = 16
#: Decimals of residuals and of chi-squared: further decimals are rounding errors.
_DECIMALS = 3
#: Residuals larger than this many deviations are marked.
_LARGE = 3.0
#: Parts of a pose smaller than this are shown as zero, lengths by the platform's.
_ZERO = 1e-12
#: Components of quaternions that differ by less are of one orientation.
_SAME = 1e-9
#: Significant digits of condition numbers.
_DIGITS = 3
#: Poses that are this many lengths away are called nearly infinite.
_FAR = 1e5
#: The columns of a refined pose, real parts first.
DECIMALS = tuple(
    f"refined_{name}{suffix}"
    for suffix in ("", "_imag")
    for name in (*(f"R{i}{j}" for i in "123" for j in "123"), "Tx", "Ty", "Tz")
)

digits_option = options.option(
    "--digits N",
    "Also print each certified solution to N proved digits.",
    type=click.IntRange(1, 100_000),
)


def _conditions(_: click.Context, __: click.Parameter, texts: Sequence[str]) -> list[Condition]:
    """Return the conditions of `--where`."""
    if not texts:
        return []
    from gspcli.motion.poses.mode_filters import parse_conditions

    try:
        return [one for text in texts for one in parse_conditions(text)]
    except ArgumentError as error:
        raise GspError(f"--where: {error}") from None


@click.command(cls=options.Command)
@options.without(
    "--fit", "--all", "--near", "--digits", "--prove", "--where", "--within-limits", "--above"
)
@options.needs("--sigma", "--fit")
@options.needs("--euler", "--near", "--where")
@options.needs("--pivot", "--near", "--where")
@click.argument("specs", metavar="SPEC...", nargs=-1, required=True)
@options.option(
    "--lines",
    "SPEC has an instance in each line, as JSON: the default for files that end with .jsonl.",
    name="by_line",
)
@options.value_options
@options.option("--all", "Also show the complex solutions.", name="everything")
@options.option(
    "--prove/--no-prove",
    "--prove counts the poses of a special platform exactly, for any time, modulo two random "
    "primes. --no-prove never counts. By default poses are counted if that takes a few seconds at "
    "most.",
    default=None,
)
@options.seed_option("; the answer does not depend on it")
@options.jobs_option
@options.option(
    "--rotation FORM",
    "Write rotations as quaternion, matrix, rotvec, or angles about axes: ZYX and the like about "
    "those of the platform, xyz about those of the base, PI, LinuxCNC or Symetrie.",
    default="quaternion",
)
@options.decimals_option(None, 0, 17, ": positions and rotations, independently of the width")
@near_option("poses are sorted by their distance from it")
@pose_options
@options.option(
    "--where CONDITION",
    "List only real poses with this, such as 'z>0, rx<=45': x, y, z, and rx, ry, rz in the order "
    "of --euler or ZYX; may be repeated.",
    multiple=True,
    callback=_conditions,
)
@options.option("--within-limits", "List only real poses within all ranges and cones.")
@options.option(
    "--above",
    "List only real poses with the platform above its base: on the side of home, or of z.",
)
@options.option(
    "--reading READING",
    "The reading of one more sensor with its standard deviation, such as 'leg P1 B3 = 212.4 ± 0.1' "
    "(or +-), in the units of SPEC. The mode that fits is marked. May be repeated.",
    name="readings",
    multiple=True,
)
@options.option(
    "--fit",
    "Take the values and all readings as measurements with errors: the least-squares pose of each "
    "mode, whether it fits, and which measurement is the outlier.",
    name="fitting",
)
@options.option(
    "--sigma WHAT=NUMBER",
    "Standard deviation of what is measured: value (distances), angle, or the number of a "
    "constraint; else `tolerance` in SPEC. With --fit; may be repeated.",
    name="sigmas",
    multiple=True,
)
@digits_option
@options.output_options(formats=(*options.FORMATS, LINES))
def command(o: options.Options) -> int:
    """Find every pose of a platform and account for every path.

    SPEC is an instance file, - for standard input, or @NAME of an example (`gsp example`). The
    first line states how many poses are real, what is proved, and whether these are all. Then each
    real pose is one line: the position T of the platform's origin and its rotation R (x_base = R
    x_platform + T), the condition number, and remarks. Three angles fix the orientation: then the
    orientations are listed, with the positions of each. If no pose is real, the constraints that
    contradict each other are named. JSON has all of this in full precision, and always both R and
    the quaternion.

    With --where, --within-limits or --above the other real poses are counted and not listed, and
    home is chosen among those listed. Numbers of modes and the statement about completeness do not
    change.

    --reading gives what one more sensor reads, and marks the modes at which it would read this,
    within three standard deviations. gsp sensors says which sensor distinguishes the modes, and how
    readings are written.

    --fit fits poses to more than six measurements with errors: the six values, and the readings of
    --reading or of the list `readings` in SPEC. Each minimum of the sum of squares that was found
    is shown with its pose, chi-squared and its probability; JSON has the covariance, too. If none
    fits, the outlier is named, with the fit without it. The fits start from all poses of several
    choices of six measurements. It is not proved that all minima are found.

    Given several SPEC, or with --lines, each instance has one line of the answer, in their order.
    An error in one does not stop the others. --format jsonl prints the whole document of each
    instance in a line. --jobs is then the number of processes. The exit code is the largest of any
    instance.

    Exit codes: 0 done (no real pose is an answer, too); 1 no mode or several fit the readings;
    2 bad input; 3 the poses are infinitely many; 4 something could not be found or certified.

    \b
    Examples:
      gsp solve @example-6.8
      gsp solve platform.yaml --set 1=5.2 --set 4=60 --format csv
      gsp solve @dietmaier --digits 50 -o poses.json
      gsp solve platform.yaml --rotation ZYX --near 0,0,250,0,0,0 --euler ZYX
      gsp solve @workspace-study --above --where "rz>-45, rz<45"
      gsp solve @rubin-m2 --reading "leg P1 B2 = 2.913 ± 0.002"
      gsp solve @rubin-m2 --reading "leg P1 B2 = 2.913 ± 0.002" \\
        --fit --sigma value=1e-5
      gsp solve @dietmaier @figure-3 --format jsonl -o answers.jsonl
      gsp solve instances.jsonl --jobs 2
      gsp new "DPL DPL DLP ALL ALL ALH" | gsp solve - --all -o poses.json
    """
    columns = rotation_columns(o.rotation)
    if o.rotation.strip().lower() in MAKERS:
        options.order_named("--rotation", o.rotation)
    if o.everything and o.rotation not in ("quaternion", "matrix"):
        raise click.UsageError(
            f"--rotation {o.rotation} cannot write complex solutions: leave out --all"
        )
    if len(o.specs) > 1 or o.output.format == LINES or _has_lines(o, o.specs[0]):
        return _solve_many(o)
    o.spec = o.specs[0]
    readings, frame = _readings(o), o.frame_of(o.instance)
    if o.fitting:
        return _show_fit(o, readings, columns, frame)
    goal = None if o.near is None else o.near.read(o.form)
    with working("solving"):
        answer = _answered(o, o.instance, frame, columns, o.jobs)
        if goal is not None:
            answer = answer.sorted_by_distance(*goal)
        if readings:
            from gspcli.sensing import fit_readings

            answer = replace(answer, fit=fit_readings(answer.result, readings))
        if o.output.format == "json":
            emit(o.output, (), document=answer.document)
        else:
            emit(o.output, answer.csv() if o.output.format == "csv" else answer.tables())
    result, fit = answer.result, answer.fit
    if result.home is not None and result.home.doubt and not o.changes.given:
        say(f"warning: {result.home.doubt}")
    _complain(result)
    if fit is not None and fit.mode is None:
        if fit.modes:
            raise CheckFailed(
                f"{len(fit.modes)} modes fit what was read: gsp sensors says which further sensor "
                "tells them apart"
            )
        raise CheckFailed(
            "no mode fits what was read: is it in the units of SPEC, with the values of SPEC "
            "(--set gives others)?"
        )
    return 0


def _readings(o: options.Options) -> list[SensorReading]:
    """Return the readings that are given; with `--fit` they may be those of constraints, too."""
    if not o.readings:
        return []
    from gspcli.sensing.sensor_kinds import parse_reading

    readings = []
    for text in o.readings:
        try:
            readings.append(parse_reading(text, o.instance, repeated=o.fitting))
        except GspError as error:
            raise GspError(f"--reading {shown(text)}, {error}") from None
    return readings


def _answered(
    o: options.Options, instance: Instance, frame: PoseFrame, turns: Sequence[PoseColumn], jobs: int
) -> Answer:
    """Solve an instance, and choose the poses that are shown; the others are not home."""
    from gspcli.solver import solve

    result, omitted = solve(instance, seed=o.seed, jobs=jobs, prove=o.prove), None
    if o.where or o.within_limits or o.above:
        from gspcli.motion.poses.mode_filters import ModeFilter

        form = o.form_of(instance)
        asked = ModeFilter(o.where, o.within_limits, o.above, form.pivot_frame, form.euler or "ZYX")
        try:
            omitted = asked.left_out(result)
        except ArgumentError as error:
            raise GspError(f"--{error.where.replace('_', '-')}: {error.message}") from None
        numbers = sorted(k - 1 for those in omitted.values() for k in those)
        result = replace(result, left_out=tuple(numbers))
    poses = range(len(result.R) if o.everything else result.counts.real)
    indices = [k for k in poses if k not in result.left_out]
    columns = expressed_columns((*TRANSLATION, *turns), frame)
    return Answer(result, o, columns, frame, indices, omitted)


@dataclass(frozen=True, eq=False)
class Answer:
    """A result, and which of its poses are shown, and how."""

    result: SolveResult
    o: options.Options
    #: Those of positions and rotations, as they are expressed in `frame`.
    columns: Sequence[PoseColumn]
    frame: PoseFrame
    #: The poses in the order of the table; the real ones are the first.
    indices: Sequence[int]
    #: The numbers of the real poses that are not shown, by reasons; None without a filter.
    omitted: Mapping[str, list[int]] | None = None
    #: For each pose of the table its distance from the pose of ``--near``: the translation and the
    #: angle, in the units of the instance; None without the option.
    distances: Sequence[tuple[float, float]] | None = None
    #: How the readings fit the modes, if there are any.
    fit: ReadingFit | None = None

    def sorted_by_distance(self, R: Any, T: Any) -> Answer:
        """Return the real poses by their distance from one, and the distances."""
        from gspcli.geometry.home_mode import distances

        result = self.result
        chosen = np.array([k for k in self.indices if result.real[k]], dtype=int)
        moved, turned = distances(result.R[chosen].real, result.T[chosen].real, R, T)
        order = np.argsort(np.hypot(moved, result.arrangement.length * turned), kind="stable")
        pairs = np.stack((moved, turned / result.arrangement.in_radians), axis=1)[order]
        sorted_ = chosen[order].tolist()
        return replace(self, indices=sorted_, distances=list(map(tuple, pairs.tolist())))

    @cached_property
    def digits(self) -> list[dict[str, Any] | None]:
        """Each pose with proved digits, if they are asked for; None if it is not certified."""
        result, indices, digits = self.result, list(self.indices), self.o.digits
        if digits is None or not indices:
            return []
        from gspcli.certification import certify

        sides = result.sides[indices]
        proofs = certify(result.instance, result.R[indices], result.T[indices], sides=sides)
        return [refined(result.instance, one, digits) if one.certified else None for one in proofs]

    @cached_property
    def contradicting(self) -> list[int]:
        """The numbers of constraints that contradict each other, if that is why none is real."""
        if self.result.counts.real or self.result.verdict != "complete":
            return []
        from gspcli.reality.contradiction import contradiction

        return [k + 1 for k in contradiction(self.result.arrangement)]

    @property
    def sentences(self) -> list[str]:
        """The result in sentences, with what is omitted and which modes fit."""
        lines = summary(self.result, contradicting=self.contradicting)
        if self.omitted is not None:
            parts = [f"{len(those)} by {reason}" for reason, those in self.omitted.items()]
            real, what = self.result.counts.real, ", ".join(parts) or "none"
            kept = real - sum(map(len, self.omitted.values()))
            lines.append(f"{kept} of {counted(real, 'real pose')} kept; left out: {what}")
        return lines if self.fit is None else [*lines, self.fit.sentence]

    @property
    def document(self) -> dict[str, Any]:
        """The result for JSON, with the digits and readings that were asked for."""
        document = self.result.to_json(everything=self.o.everything)
        entries = [document["solutions"][k] for k in self.indices]
        for entry, pose in zip(entries, self.digits, strict=False):
            entry["refined"] = pose
        for entry, (length, angle) in zip(entries, self.distances or (), strict=False):
            entry["distance"] = {"translation": length, "turn": angle}
        if not self.frame.is_identity:
            document["frames"] = self.frame.to_json()
            for entry, k in zip(entries, self.indices, strict=True):
                if self.result.real[k]:
                    entry["expressed"] = self._expressed(k)
        if self.omitted is not None:
            modes = sorted(number for those in self.omitted.values() for number in those)
            reasons = [{"reason": why, "modes": those} for why, those in self.omitted.items()]
            document["left_out"] = {"modes": modes, "reasons": reasons}
        document["solutions"] = entries
        if self.contradicting:
            document["contradicting"] = self.contradicting
        if self.fit is not None:
            document |= self.fit.to_json()
            for entry, k in zip(entries, self.indices, strict=True):
                if k < len(self.fit.off) and self.fit.result.counts.real:
                    entry |= self.fit.of_mode(k)
        return document

    def _expressed(self, k: int) -> dict[str, Any]:
        R, T = self.frame.from_platform(self.result.R[k].real, self.result.T[k].real)
        return {"position": T.tolist(), "quaternion": quaternion_from_rotation(R).tolist()}

    def _rows(self) -> list[dict[str, Any]]:
        """Return all numbers of each pose, those of complex solutions as complex ones."""
        read = {column.key: column.read(self.result) for column in (*self.columns, *FACTS)}
        rows = [
            {"number": k + 1, **{key: _plain(values[k]) for key, values in read.items()}}
            for k in self.indices
        ]
        for row, (length, angle) in zip(rows, self.distances or (), strict=False):
            row |= {"distance": length, "turn": angle}
        fits = [] if self.fit is None else self.fit.rows()
        for row, k in zip(rows, self.indices, strict=True):
            if k < len(fits) and self.result.real[k]:
                row |= fits[k]
        for row, pose in zip(rows, self.digits, strict=False):
            row |= digit_cells(pose or {})
        return rows

    def csv(self) -> Result:
        """Return every column of the poses, for programs."""
        rows = []
        for row in self._rows():
            numbers = {key: x for key, x in row.items() if isinstance(x, complex)}
            rows.append(row | {key: x.real for key, x in numbers.items()})
            if not row["real"]:
                rows[-1] |= {f"{key}_imag": x.imag for key, x in numbers.items()}
        keys = ["number", *(column.key for column in (*self.columns, *FACTS))]
        keys += [] if self.distances is None else ["distance", "turn"]
        keys += [] if self.fit is None else ["off", "fits"]
        keys += [f"{column.key}_imag" for column in self.columns] if self.o.everything else []
        keys += [key for key in DECIMALS if any(key in row for row in rows)]
        return Result([Field(key) for key in keys], rows, summary=self.sentences, part="poses")

    def tables(self) -> list[Result]:
        """Return the result for people: poses, those that cannot move, proved digits."""
        result = self.result
        notes = [*frame_note(self.frame), *remarks(result, [k + 1 for k in self.indices])]
        if not self.o.everything and (others := len(result.R) - result.counts.real):
            notes.append(f"--all shows the {counted(others, 'complex solution')}, too")
        if self.distances is not None:
            notes.append("nearest: by the translation and the turn times the platform's size")
        tables = [*self._pose_tables(self.sentences, notes), *self._lone_tables()]
        if any(self.digits):
            tables.append(digit_table(self._rows()))
        return tables

    def _lone_tables(self) -> list[Result]:
        """Return the real poses that are isolated over the real but not over the complex numbers.

        As equations over the complex numbers the constraints are singular there.
        """
        lone = self.result.lone
        if not len(lone.R):
            return []
        indices = range(len(lone.R))
        alone = replace(self, result=lone, indices=indices, distances=None, fit=None)
        notes = [
            "none of these real poses can move, and there are no others: known by exact counts. "
            "That all constraints hold there is checked to 50 decimals; to 9 where poses meet, and "
            "for the distance of parallel lines"
        ]
        tables = []
        for table in alone._pose_tables([], notes):
            kept = [one for one in table.columns if one.key not in ("condition", "residual")]
            tables.append(replace(table, title="real poses", columns=kept))
        return tables

    def _pose_tables(self, lines: Sequence[str], notes: Sequence[str]) -> list[Result]:
        """Return the poses: units in the headings, exceptions marked."""
        instance = self.result.instance
        title, units = instance.title, instance.units
        if not self.indices:
            return [Result([], [], title, notes, lines)]
        rows, number = self._rows_for_people(), FIELDS["number"]
        poses = [pose_field(column, instance, self.o.decimals) for column in self.columns]
        sided = np.flatnonzero(self.result.arrangement.sided) + 1
        last = [
            FIELDS["distance"].but(title=f"distance [{units.length}]"),
            FIELDS["turn"].but(title=f"turn [{units.angle.value}]"),
            FIELDS["off@2"],
            FIELDS["sides"].but(title=f"sides {','.join(map(str, sided))}"),
            *FIELDS.of("residual condition remarks@2"),
        ]
        last = [column for column in last if any(row.get(column.key) is not None for row in rows)]
        orientations = self._orientations()
        if not orientations:
            return [Result([number, *poses, *last], rows, title, notes, lines, "poses")]
        by_number = {row["number"]: row for row in rows}
        leaders = []
        for letter, group in orientations.items():
            for k in group:
                by_number[k + 1]["orientation"] = letter
            leaders.append(by_number[group[0] + 1] | {"positions": len(group)})
        of_each = [FIELDS["orientation"], *poses[3:], FIELDS["positions"]]
        columns = [number, FIELDS["orientation"], *poses[:3], *last]
        return [
            Result(of_each, leaders, title, (), lines, "orientations"),
            Result(columns, rows, notes=notes, part="poses"),
        ]

    def _rows_for_people(self) -> list[dict[str, Any]]:
        """Return the rows with few digits, and in words what is not the rule."""
        result = self.result
        length, known = result.arrangement.length, proved(result)
        all_stated = (result.arrangement.signs != 0)[result.arrangement.sided].all()
        same = len({tuple(one.sides.items()) for one in result.solutions}) == 1 and all_stated
        lengths = [column.key for column in self.columns if column.unit == "length"]
        rows = self._rows()
        for place, (row, index) in enumerate(zip(rows, self.indices, strict=True)):
            pose, many = result.solutions[index], row["multiplicity"]
            for column in self.columns:
                smallest = _ZERO * length if column.key in lengths else _ZERO
                row[column.key] = _rounded(row[column.key], smallest)
            sides = ["+" if side == "positive" else "-" for side in pose.sides.values()]
            row["sides"] = "".join(sides) if sides and not same else None
            row["condition"] = float(f"{pose.condition:.{_DIGITS}g}")
            row["residual"] = None if known[index] else printed_residual(pose.residual, length)
            if "off" in row:
                row["off"] = float(f"{row['off']:.3g}")
            said = {
                "home": pose.home,
                "nearest": self.distances is not None and place == 0,
                "fits": row.get("fits"),
                "complex": not pose.real,
                "double" if many == 2 else f"multiplicity {many}": many > 1,
                "not proved": not known[index] and known.any(),
            }
            row["remarks"] = ", ".join(what for what, holds in said.items() if holds) or None
        return rows

    def _orientations(self) -> dict[str, list[int]]:
        """Return the poses by orientation, which three angles determine; empty if it is no help."""
        result = self.result
        if len(result.arrangement.angles) != MAX_ANGLES or self.distances is not None:
            return {}
        if not result.real[list(self.indices)].all():
            return {}
        groups: list[list[int]] = []
        for index in self.indices:
            q = result.quaternions[index]
            if groups and np.abs(q - result.quaternions[groups[-1][0]]).max() < _SAME:
                groups[-1].append(index)
            else:
                groups.append([index])
        if len(groups) == len(self.indices):
            return {}
        alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
        letters = chain(alphabet, map("".join, product(alphabet, repeat=2)))
        return dict(zip(letters, groups, strict=False))


def pose_field(column: PoseColumn, instance: Instance, decimals: int | None) -> Field:
    """Return a column of poses for people, with its unit in the heading."""
    units = {"": "", "length": instance.units.length, "angle": instance.units.angle.value}
    heading = f"{column.key} [{units[column.unit]}]" if column.unit else column.key
    return Field(column.key, heading, "right", essential=True, aligned=True, decimals=decimals)


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _rounded(value: Any, smallest: float) -> float | complex:
    """Return a number with rounding errors about zero taken away, real if it is."""
    number = complex(value)
    parts = [part if abs(part) > smallest else 0.0 for part in (number.real, number.imag)]
    return parts[0] if parts[1] == 0 else complex(*parts)


def summary(result: SolveResult, *, contradicting: Sequence[int] = ()) -> list[str]:
    """Return the result in lines: the real poses, what is proved, whether these are all."""
    lines = [_real_words(result), _completeness(result)]
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
    known = proved(result)[: real or None]
    if known.all():
        return text + (", each proved, all different" if real > 1 else ", proved")
    some = f", {known.sum()} of them proved" if known.any() else ", not proved"
    return text + some if real else text


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
    """Return the verdict, the solutions found by sorts, and how many other platforms have."""
    ends, found, expected = result.account, result.counts.found, result.expected
    verdict = f"{result.verdict}, {result.proof.words}" if result.proof else result.verdict
    arrangement, complete = result.arrangement, result.verdict == "complete"
    sides = " with these sides" if arrangement.signs[arrangement.sided].any() else ""
    usual = f"most platforms of this type{sides} have {expected}"
    if result.verdict == "infinite":
        isolated = f"{found or 'no'} isolated one{'s' * (found != 1)}"
        where = " over the complex numbers" if len(result.lone.R) else ""
        return f"{verdict}: infinitely many solutions{where} and {isolated} ({usual})"
    geometry = expected if complete and found == expected else result.geometry_count
    whose, whole = "this geometry", geometry or 0
    if geometry in (None, expected):
        whose, whole, usual = "the type", expected, ""
    if complete and found == ends.found == geometry:
        parts = [f"all {counted(found, 'solution')} of {whose} found" if found else "no solution"]
    else:
        parts = [f"{counted(found, 'solution')} found"]
    sorts = {"real": result.counts.real, "complex": found - result.counts.real}
    sorted_ = [f"{'all' if n == found > 1 else n} {sort}" for sort, n in sorts.items() if n]
    parts += [" and ".join(sorted_)] if found else []
    parts += [f"{ends.found} with multiplicity"] if ends.found != found else []
    # The causes for which the geometry has fewer solutions than the type are not listed.
    if geometry is None or ends.on_curves + ends.spurious + ends.lost:
        elsewhere = {
            "at infinity": ends.at_infinity,
            "on curves": ends.on_curves,
            "where parallel lines have another distance": ends.spurious,
            "lost": ends.lost,
        }
        parts += [f"{count} {place}" for place, count in elsewhere.items() if count]
    # A platform can have more solutions than its geometry has for almost all values.
    if complete and whole > ends.found:
        parts.append(f"where {whose} has {whole} for most values")
    elif found != whole >= ends.found:
        parts.append(f"{'all ' * complete}of {whose}'s {whole}")
    return f"{verdict}: {', '.join(parts)}" + (f" ({usual})" if usual else "")


def _reason(result: SolveResult, contradicting: Sequence[int]) -> str:
    constraints = result.instance.constraints
    kinds = {constraints[k - 1].kind.is_distance for k in contradicting}
    what = "constraint" if len(kinds) > 1 else "distance" if kinds == {True} else "angle"
    if len(contradicting) == 1:
        return f"no pose was found for {what} {contradicting[0]} alone"
    if len(contradicting) == len(constraints):
        return "any five of the constraints have common poses, all six have none"
    return (
        f"{what}s {listed(map(str, contradicting), 'and')} contradict each other: "
        "no pose was found for them without the others"
    )


def remarks(result: SolveResult, numbers: Sequence[int]) -> list[str]:
    """Return notes on the poses shown, whose numbers count from 1."""
    causes = [*_far(result), *_parallel(result)]
    if result.proof is not None and result.proof.reservation:
        causes.append(result.proof.reservation)
    if not numbers:
        return causes
    shown = [number - 1 for number in numbers]
    residual = printed_residual(float(result.residuals[shown].max()), result.arrangement.length)
    # Mirrored poses differ in the last digits. Of poses with equal rounded numbers the first is
    # named.
    condition = np.array([float(f"{x:.{_DIGITS}g}") for x in result.conditions[shown]])
    best, worst = int(np.argmin(condition)), int(np.argmax(condition))
    lowest, highest = (f"{condition[k]:.{_DIGITS}g}" for k in (best, worst))
    if lowest != highest:
        of = f"{lowest} (pose {numbers[best]}) to {highest} (pose {numbers[worst]})"
    else:
        of = f"{lowest} at every pose"
    met = f"values are met within {residual:.0e}; condition {of}: 1 is best, infinite is singular"
    home = [result.home.text] if result.home and result.counts.real else []
    return [met, *home, *_limits(result, numbers), *causes]


def _limits(result: SolveResult, numbers: Sequence[int]) -> list[str]:
    """Say which of the real poses shown are outside the ranges and cones of the machine."""
    poses = {number: result.solutions[number - 1] for number in numbers}
    limits = [(number, one) for number, pose in poses.items() for one in pose.limits or ()]
    notes = [
        f"constraint {k} is outside its range: the machine can take none of these poses"
        for k in sorted({one.constraint + 1 for _, one in limits if one.kind == "range"})
    ]
    sentences = {
        "cone": "a leg leaves the cone of a joint",
        "working mode": "an arm or carriage is on the other side of its dead point than at home",
    }
    for kind, said in sentences.items():
        if beyond := [*dict.fromkeys(number for number, one in limits if one.kind == kind)]:
            plural = "s" * (len(beyond) > 1)
            notes.append(f"{said} in pose{plural} {', '.join(map(str, beyond))}")
    return notes


def _far(result: SolveResult) -> list[str]:
    """Say how many poses are nearly at infinity."""
    arrangement = result.arrangement
    offset = result.R @ arrangement.platform_centre + result.T - arrangement.base_centre
    far = int((np.abs(offset).max(axis=1) > _FAR * arrangement.length).sum())
    said = f"{far} of the {result.counts.found} solutions lie beyond {_FAR:.0e} lengths: "
    return [f"{said}caused by rounded coordinates, harmless"] if far else []


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
    return [
        f"the lines of constraint{'s' * (len(numbers) > 1)} {listed(numbers, 'and')} are parallel "
        "at every pose: a point of one has its distance from the other"
    ]


def refined(instance: Instance, certificate: Certificate, digits: int) -> dict[str, Any]:
    """Return R and T of a certified pose as decimal strings with proved digits, for JSON."""
    from gspcli.certification import refine

    pose = refine(instance, certificate, digits)
    entries = {key: getattr(pose, key) for key in ("R", "T", "R_imag", "T_imag")}
    return {key: value for key, value in entries.items() if value is not None}


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
    return Result(FIELDS.of("number entry value"), lines, "Proved digits", part="digits")


def _complain(result: SolveResult) -> None:
    """Raise the error that sets the exit code, if there is one."""
    counts, account = result.counts, result.account
    if result.verdict == "infinite":
        message = "the poses are infinitely many"
        motion = result.motions[0] if result.motions else None
        if count := len(result.lone.R):
            alone = f"{count} are real" if count > 1 else "one is real"
            message += f" over the complex numbers; {alone}, and cannot move"
        elif fixed(result):
            message += " in another component; from the isolated real ones the platform cannot move"
            if motion is not None:
                message += (
                    "\n(numerical evidence: that component has local dimension "
                    f"{motion.dimension}; --format json has a sample)"
                )
        elif motion is not None:
            how = "the platform can move" if motion.real else "over the complex numbers"
            message += (
                f": {how}, with local dimension {motion.dimension}\n"
                "(numerical evidence; --format json has sample motions)"
            )
        raise NotFiniteError(message)
    if account.lost:
        from gspcli.spec import out_of_proportion

        message = f"{account.lost} of {result.expected} expected solutions could not be classified"
        if disproportion := out_of_proportion(result.instance):
            raise IncompleteError(f"{message}:\n{disproportion}")
        raise IncompleteError(
            f"{message}: the platform is in or near a special position\n"
            "try --prove, another --seed, or change a value a little with --set and compare"
        )
    missing = counts.found - counts.certified
    if result.proof is None and missing > 0:
        raise IncompleteError(f"{missing} of {counts.found} poses could not be certified")


def _has_lines(o: options.Options, spec: str) -> bool:
    """Return whether a file has an instance in each line."""
    return o.by_line or spec.lower().endswith(LINE_SUFFIXES)


def _solve_many(o: options.Options) -> int:
    """Solve instances one after the other; write an answer for each, in their order.

    Answers in JSON, one a line, are written as soon as they are known. An error of one instance is
    part of its answer, and the others are solved.
    """
    alone = {"--near": o.near, "--reading": o.readings, "--fit": o.fitting}
    given = [name for name, value in alone.items() if value]
    given += [name for name in o.conventions if name != options.RELATIVE]
    if given:
        raise click.UsageError(f"{listed(given, 'and')}: for one SPEC and its table only")
    if o.specs.count("-") > 1:
        raise GspError("standard input can be one SPEC only: - is given more than once")
    by_line = {spec: _has_lines(o, spec) for spec in o.specs}
    sources = chain.from_iterable(
        _lines_of(spec) if by_line[spec] else [(spec, None)] for spec in o.specs
    )
    from gspcli.workers import Workers

    answer = partial(_answer, o)
    first = map(answer, islice(sources, _HERE_FIRST))
    answers: Iterator[Any] = chain(first, Workers(o.jobs).in_order(answer, sources))
    as_lines = o.output.format == LINES
    streamed = as_lines and o.output.path is None
    if not (streamed and sys.stdout.isatty()):
        # A progress bar would be printed between the lines.
        total = None if any(by_line.values()) else len(o.specs)
        answers = progress(answers, total=total, label="instances")
    rows, texts = [], []
    for row, document in answers:
        rows.append(row)
        if as_lines:
            texts.append(json.dumps(document, ensure_ascii=False) + "\n")
        if streamed:
            sys.stdout.write(texts.pop())
            sys.stdout.flush()
    if not rows:
        raise GspError(f"{', '.join(o.specs)}: found no instance, expected one in each line")
    codes: list[int] = [row["exit_code"] for row in rows]
    counts = {
        "complete": codes.count(0),
        "infinitely many poses": codes.count(3),
        "not completed": codes.count(4),
        "wrong": codes.count(1) + codes.count(2),
    }
    parts = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    said = f"{len(rows)} instances: {parts}"
    if not as_lines:
        columns = FIELDS.of("instance name type real@2 found certified@2 verdict exit_code message")
        emit(o.output, Result(columns, rows, notes=[said], schema="solve-list", name="rows"))
    elif not streamed:
        write(o.output, "".join(texts))
    if as_lines and max(codes):
        say(said)
    return max(codes)


def _lines_of(spec: str) -> Iterator[tuple[str, str]]:
    """Yield the name and the text of each line of a file that is not empty."""
    from gspcli.spec.document import LARGEST_SPEC

    name = "standard input" if spec == "-" else spec
    try:
        # A descriptor, closed at the end unless it is standard input.
        with open(0 if spec == "-" else spec, "rb", closefd=spec != "-") as file:
            for number, line in enumerate(iter(partial(file.readline, LARGEST_SPEC + 1), b""), 1):
                if len(line) > LARGEST_SPEC:
                    raise GspError(
                        f"{named(name)}: line {number} has more than {LARGEST_SPEC >> 20} MB"
                    )
                if line.strip():
                    yield f"{name}, line {number}", line.decode("utf-8-sig", "surrogateescape")
    except (OSError, ValueError) as error:
        raise GspError(
            f"{named(name)}: cannot be read: {getattr(error, 'strerror', None) or error}"
        ) from error


def _answer(
    o: options.Options, source: tuple[str, str | None]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the row and the document of one instance; its error, if any, is part of both.

    A source is the name of an instance, and its text; None if it is the name of a file.
    """
    name, text = source
    row: dict[str, Any] = {"verdict": "no answer"}
    document: dict[str, Any] = {}
    said: dict[str, Any] = {"instance": name, "exit_code": 0, "message": None}
    try:
        instance = o.changes.of(_instance(name, text))
        answer = _answered(o, instance, o.frame_of(instance), (), 1)
        result = answer.result
        if o.output.format == LINES:
            document = answer.document
        counts = result.counts
        row = {
            "name": instance.name or None,
            "type": instance.type.id,
            "real": counts.real,
            "found": counts.found,
            "certified": counts.certified,
            "verdict": result.verdict,
        }
        _complain(result)
    except GspError as error:
        said |= {"exit_code": error.exit_code, "message": str(error)}
    message = said["message"] and said["message"].replace("\n", "; ")
    return {**row, **said, "message": message}, {**said, **document}


def _instance(name: str, text: str | None) -> Instance:
    from gspcli.spec import read, read_text

    if text is None:
        return read(spec_source(name)).instance
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise GspError(f"{name}: expected text in UTF-8") from error
    return read_text(text, name=name).instance


def _show_fit(
    o: options.Options,
    readings: Sequence[SensorReading],
    rotation: Sequence[PoseColumn],
    frame: PoseFrame,
) -> int:
    """Fit poses to all measurements, and write them with residuals."""
    from gspcli.sensing import fit_poses

    if not readings and not o.instance.readings:
        raise GspError(
            "--fit needs readings besides the six values: --reading 'leg P1 B3 = 212.4 ± 0.1', or "
            "`readings` in SPEC"
        )
    with working("fitting"):
        fit = fit_poses(o.instance, readings or None, sigma=standard_deviations(o.sigmas))
    document = {"schema": "gsp.solve/1", **o.instance.to_json(), "fit": fit.to_json()}
    tables = [_fitted_poses(fit, rotation, o.decimals, frame)]
    tables += [_residuals(fit)] if fit.poses and o.output.format != "csv" else []
    emit(o.output, tables, document=document)
    if len(fit.fitting) == 1:
        return 0
    if fit.fitting:
        raise CheckFailed(
            f"{len(fit.fitting)} poses fit: gsp sensors says which further sensor tells modes apart"
        )
    why = fit.sentences[2] if len(fit.sentences) > 2 else fit.sentences[0]
    raise CheckFailed(f"no pose fits what was measured: {why}")


def _fitted_poses(
    fit: PoseFit, rotation: Sequence[PoseColumn], decimals: int | None, frame: PoseFrame
) -> Result:
    """Return a row for each pose."""
    instance, rows = fit.numbers.instance, fit.rows()
    R = np.array([pose.R for pose in fit.poses]).reshape(-1, 3, 3)
    T = np.array([pose.T for pose in fit.poses]).reshape(-1, 3)
    poses = expressed(frame, Arrangement.of(instance), R, T, np.ones(len(R), bool))
    written = (*TRANSLATION, *rotation)
    for column in written:
        for row, cell in zip(rows, column.read(poses), strict=True):
            row[column.key] = float(cell)
    for row in rows:
        row["chi_squared"] = round(float(f"{row['chi_squared']:.4g}"), _DECIMALS)
        for key in ("probability", "sigma_T", "sigma_turn"):
            row[key] = float(f"{row[key]:.2g}")
    columns = [
        FIELDS["number"],
        *(pose_field(column, instance, decimals) for column in written),
        *FIELDS.of("chi_squared probability"),
        FIELDS["sigma_T"].but(title=f"± T [{instance.units.length}]"),
        FIELDS["sigma_turn"].but(title=f"± turn [{instance.units.angle.value}]"),
        FIELDS["fits"],
    ]
    notes = ["± of one axis, the largest of three; of the platform's origin"]
    if not frame.is_identity:
        notes.append(f"poses are {frame.words}")
    return Result(columns, rows, instance.title, notes=notes, summary=fit.sentences, part="poses")


def _residuals(fit: PoseFit) -> Result:
    """Return the residuals of the best pose."""
    best = fit.poses[0]
    rows: list[dict[str, Any]] = [
        {
            "measured": fit.numbers.names[owner],
            "off": round(off, _DECIMALS),
            "studentised": None if size != size else round(size, _DECIMALS),
            "remarks": "large" if abs(size) > _LARGE else "",
        }
        for owner, off, size in zip(
            best.owners.tolist(), best.residuals.tolist(), best.studentised.tolist(), strict=True
        )
    ]
    numbers = [FIELDS[key].but(decimals=_DECIMALS) for key in ("off", "studentised")]
    notes = [
        "off: measured less fitted, at pose 1; studentised: over the deviation of that difference, "
        "empty where no other measurement checks it"
    ]
    columns = [FIELDS["measured"], *numbers, FIELDS["remarks"]]
    return Result(columns, rows, notes=notes, part="residuals")
