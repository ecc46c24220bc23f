"""`gsp solve`: every pose of a platform given in a file."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, islice
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from gspcli.cli.options import (
    FORMATS,
    Changes,
    Command,
    Options,
    decimals_option,
    jobs_option,
    load_instance,
    output_options,
    seed_option,
    spec_source,
    standard_deviations,
    together,
    value_options,
)
from gspcli.cli.pose_options import (
    RELATIVE,
    GivenPose,
    PoseConventions,
    frame_note,
    near_option,
    order_named,
    pose_options,
)
from gspcli.cli.pose_tables import digit_cells, digit_table, digits_option, refined
from gspcli.cli.render import Output, emit, write
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.streams import progress, say, working
from gspcli.errors import (
    ArgumentError,
    CheckFailed,
    GspError,
    IncompleteError,
    NotFiniteError,
    SpecError,
)
from gspcli.records import dataclass
from gspcli.wording import listed
from gspcli.wording import shown as quoted

if TYPE_CHECKING:
    from gspcli.cli.options import Changes
    from gspcli.cli.pose_options import PoseConventions
    from gspcli.cli.pose_tables import Shown
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion.poses.mode_filters import Condition
    from gspcli.sensing import PoseFit, ReadingFit
    from gspcli.sensing.sensor_kinds import SensorReading
    from gspcli.solver import SolveResult
    from gspcli.solver.results.columns import PoseColumn

FIELDS = Fields("solve")

#: Formats for people.
_READABLE = ("table", "markdown", "latex")


@dataclass(frozen=True)
class FilterOptions:
    """The conditions that listed real poses meet.

    Attributes
    ----------
    where
        Conditions for coordinates.
    within_limits, above
        As in `gspcli.motion.poses.mode_filters.ModeFilter`.
    """

    where: tuple[Condition, ...] = ()
    within_limits: bool = False
    above: bool = False

    @property
    def options(self) -> dict[str, object]:
        """The options by their names, as they are given."""
        return {"where": self.where, "within-limits": self.within_limits, "above": self.above}

    def applied(
        self, result: SolveResult, conventions: PoseConventions
    ) -> tuple[SolveResult, dict[str, list[int]] | None]:
        """Return the result without the poses that are left out as home, and their numbers."""
        if not (self.where or self.within_limits or self.above):
            return result, None
        from gspcli.motion.poses.mode_filters import ModeFilter

        form = conventions.form(result.instance)
        sequence = form.euler or "ZYX"
        asked = ModeFilter(self.where, self.within_limits, self.above, form.pivot_frame, sequence)
        try:
            left = asked.left_out(result)
        except ArgumentError as error:
            raise GspError(f"--{error.where.replace('_', '-')}: {error.message}") from None
        out = tuple(sorted(number - 1 for those in left.values() for number in those))
        return replace(result, left_out=out), left


#: `--where`, `--within-limits` and `--above`.
filter_options = together(
    click.option(
        "--where",
        metavar="CONDITION",
        multiple=True,
        help="List only real poses with this, such as 'z>0, rx<=45': x, y, z, and rx, ry, rz in "
        "the order of --euler or ZYX; may be repeated.",
    ),
    click.option(
        "--within-limits", is_flag=True, help="List only real poses within all ranges and cones."
    ),
    click.option(
        "--above",
        is_flag=True,
        help="List only real poses with the platform above its base: on the side of home, or of z.",
    ),
)


def _parsed(texts: tuple[str, ...]) -> tuple[Condition, ...]:
    """Return the conditions of texts."""
    if not texts:
        return ()
    from gspcli.motion.poses.mode_filters import parse_conditions

    try:
        return tuple(one for text in texts for one in parse_conditions(text))
    except ArgumentError as error:
        raise GspError(f"--where: {error}") from None


def given_readings(
    texts: Sequence[str], instance: Instance, *, repeated: bool = False
) -> list[SensorReading]:
    """Return the readings that are given; if `repeated` they may be those of constraints, too."""
    if not texts:
        return []
    from gspcli.sensing.sensor_kinds import parse_reading

    found = []
    for text in texts:
        try:
            found.append(parse_reading(text, instance, repeated=repeated))
        except GspError as error:
            raise GspError(f"--reading {quoted(text)}, {error}") from None
    return found


def fitted(result: SolveResult, readings: Sequence[SensorReading]) -> ReadingFit | None:
    """Return which modes fit the readings; None without readings."""
    if not readings:
        return None
    from gspcli.sensing import fit_readings

    return fit_readings(result, readings)


def refuse_misfit(fit: ReadingFit) -> None:
    """Raise, with what to do, unless exactly one mode fits."""
    if fit.mode is not None:
        return
    if fit.modes:
        message = "gsp sensors says which further sensor tells them apart"
        raise CheckFailed(f"{len(fit.modes)} modes fit what was read: {message}")
    message = "is it in the units of SPEC, with the values of SPEC (--set gives others)?"
    raise CheckFailed(f"no mode fits what was read: {message}")


def add_fit(document: dict[str, Any], shown: Shown, fit: ReadingFit) -> None:
    """Add to a document how the readings fit its poses."""
    document |= fit.to_json()
    for entry, index in zip(document["solutions"], shown.indices, strict=True):
        if index < len(fit.off) and fit.result.counts.real:
            entry |= fit.of_mode(index)


#: The ends of the names of files with an instance in each line, and the format of such answers.
LINE_SUFFIXES = (".jsonl", ".ndjson")
LINES = "jsonl"
#: This process solves this many instances before it starts others: a start takes as long as solving
#: them.
_HERE_FIRST = 16
_COLUMNS = FIELDS.of("instance name type real found certified verdict exit_code message")


class Source(NamedTuple):
    """Where an instance is."""

    name: str
    """What messages and answers call it."""
    text: str | None
    """Its text; None if the name is that of a file."""


@dataclass(frozen=True)
class Answer:
    """The answer to one instance.

    Attributes
    ----------
    row
        The row of the table.
    document
        What JSON has of it.
    """

    row: dict[str, Any]
    document: dict[str, Any]


#: Solves an instance: returns the result, its document and the error that sets the exit code.
Solving = Callable[["Instance"], tuple["SolveResult", dict[str, Any], GspError | None]]


def are_many(specs: Sequence[str], *, lines: bool) -> bool:
    """Return whether arguments name more than one instance, or may do so."""
    return lines or len(specs) > 1 or specs[0].lower().endswith(LINE_SUFFIXES)


def solve_many(
    specs: Sequence[str],
    solving: Solving,
    changes: Changes,
    jobs: int,
    output: Output,
    *,
    lines: bool,
) -> int:
    """Solve instances one after the other; write an answer for each, in their order.

    Answers in JSON, one a line, are written as soon as they are known. An error of one instance is
    part of its answer, and the others are solved.
    """
    if specs.count("-") > 1:
        raise GspError("standard input can be one SPEC only: - is given more than once")
    answers = _answers(_sources(specs, lines=lines), partial(_answer, solving, changes), jobs)
    total = None if _any_lines(specs, lines=lines) else len(specs)
    streamed = output.format == LINES and output.path is None
    if not (streamed and sys.stdout.isatty()):
        # A progress bar would be printed between the lines.
        answers = progress(answers, total=total, label="instances")
    rows, texts = [], []
    for answer in answers:
        rows.append(answer.row)
        if output.format != LINES:
            continue
        text = json.dumps(answer.document, ensure_ascii=False) + "\n"
        if streamed:
            sys.stdout.write(text)
            sys.stdout.flush()
        else:
            texts.append(text)
    if not rows:
        raise GspError(f"{', '.join(specs)}: found no instance, expected one in each line")
    if output.format != LINES:
        emit(output, Result(_COLUMNS, rows, notes=[_sum(rows)]))
    elif not streamed:
        write(output, "".join(texts))
    code: int = max(row["exit_code"] for row in rows)
    if code and output.format == LINES:
        say(_sum(rows))
    return code


def _sum(rows: Sequence[dict[str, Any]]) -> str:
    """Return how many answers there are of each kind, in words."""
    counts = {
        "complete": sum(row["exit_code"] == 0 for row in rows),
        "infinitely many poses": sum(row["exit_code"] == 3 for row in rows),
        "not completed": sum(row["exit_code"] == 4 for row in rows),
        "wrong": sum(row["exit_code"] in (1, 2) for row in rows),
    }
    parts = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    return f"{len(rows)} instances: {parts}"


def _answers(
    sources: Iterator[Source], answer: Callable[[Source], Answer], jobs: int
) -> Iterator[Answer]:
    """Yield the answers in the order of the sources."""
    from gspcli.workers import Workers

    yield from map(answer, islice(sources, _HERE_FIRST))
    more = list(islice(sources, 1))
    if more:
        yield from Workers(jobs).in_order(answer, chain(more, sources))


def _any_lines(specs: Sequence[str], *, lines: bool) -> bool:
    return lines or any(one.lower().endswith(LINE_SUFFIXES) for one in specs)


def _sources(specs: Sequence[str], *, lines: bool) -> Iterator[Source]:
    for spec in specs:
        if lines or spec.lower().endswith(LINE_SUFFIXES):
            yield from _lines_of(spec)
        else:
            yield Source(spec, None)


def _lines_of(spec: str) -> Iterator[Source]:
    """Yield the lines of a file that are not empty."""
    from gspcli.spec.document import LARGEST_SPEC
    from gspcli.wording import named

    name = "standard input" if spec == "-" else spec
    try:
        # A descriptor, closed at the end unless it is standard input.
        with open(0 if spec == "-" else spec, "rb", closefd=spec != "-") as file:
            number = 0
            while line := file.readline(LARGEST_SPEC + 1):
                number += 1
                if len(line) > LARGEST_SPEC:
                    raise GspError(
                        f"{named(name)}: line {number} has more than {LARGEST_SPEC >> 20} MB"
                    )
                if line.strip():
                    text = line.decode("utf-8-sig", errors="surrogateescape")
                    yield Source(f"{name}, line {number}", text)
    except (OSError, ValueError) as error:
        raise GspError(
            f"{named(name)}: cannot be read: {getattr(error, 'strerror', None) or error}"
        ) from error


def _answer(solving: Solving, changes: Changes, source: Source) -> Answer:
    """Return the answer to one instance; its error, if there is one, is part of the answer."""
    head = {"instance": source.name}
    try:
        instance = changes.of(_instance(source))
        result, document, error = solving(instance)
    except GspError as failure:
        said = {"exit_code": failure.exit_code, "message": str(failure)}
        return Answer(_row({**head, "verdict": "no answer", **said}), {**head, **said})
    said = {
        "exit_code": 0 if error is None else error.exit_code,
        "message": None if error is None else str(error),
    }
    counts = result.counts
    row = {
        **head,
        "name": instance.name or None,
        "type": instance.type.id,
        "real": counts.real,
        "found": counts.found,
        "certified": counts.certified,
        "verdict": result.verdict,
        **said,
    }
    return Answer(_row(row), {**head, **said, **document})


def _row(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table, its message in one line."""
    return {**row, "message": row["message"] and row["message"].replace("\n", "; ")}


def _instance(source: Source) -> Instance:
    from gspcli.spec import read, read_text

    if source.text is None:
        return read(spec_source(source.name)).instance
    try:
        source.text.encode()
    except UnicodeEncodeError as error:
        from gspcli.errors import Mistake

        message = f"{source.name}: expected text in UTF-8"
        raise SpecError([Mistake(None, "", message)]) from error
    return read_text(source.text, name=source.name).instance


#: Decimals of residuals and of chi-squared: further decimals are rounding errors.
_DECIMALS = 3
#: Residuals larger than this many deviations are marked.
_LARGE = 3.0


def show_fit(
    instance: Instance,
    readings: Sequence[SensorReading],
    sigmas: Sequence[str],
    rotation: Sequence[PoseColumn],
    decimals: int | None,
    frame: PoseFrame,
    output: Output,
) -> int:
    """Fit poses to all measurements, and write them with residuals."""
    from gspcli.sensing import fit_poses

    if not readings and not instance.readings:
        raise GspError(
            "--fit needs readings besides the six values: --reading 'leg P1 B3 = 212.4 ± 0.1', or "
            "`readings` in SPEC"
        )
    with working("fitting"):
        fit = fit_poses(instance, readings or None, sigma=standard_deviations(sigmas))
    document = {"schema": "gsp.solve/1", **instance.to_json(), "fit": fit.to_json()}
    tables = [_poses(fit, rotation, decimals, frame), *_residuals(fit)]
    if output.format == "csv":
        tables = tables[:1]
    emit(output, tables, document=document if output.format == "json" else None)
    if len(fit.fitting) == 1:
        return 0
    if fit.fitting:
        message = f"{len(fit.fitting)} poses fit: gsp sensors says which further sensor tells modes"
        raise CheckFailed(f"{message} apart")
    message = fit.sentences[2] if len(fit.sentences) > 2 else fit.sentences[0]
    raise CheckFailed(f"no pose fits what was measured: {message}")


def _poses(
    fit: PoseFit, rotation: Sequence[PoseColumn], decimals: int | None, frame: PoseFrame
) -> Result:
    """Return a row for each pose."""
    import numpy as np

    from gspcli.geometry.arrangement import Arrangement
    from gspcli.solver.results.columns import expressed

    instance = fit.numbers.instance
    R = np.array([pose.R for pose in fit.poses]).reshape(-1, 3, 3)
    T = np.array([pose.T for pose in fit.poses]).reshape(-1, 3)
    poses = expressed(frame, Arrangement.of(instance), R, T, np.ones(len(R), bool))
    rows = fit.rows()
    for row, place in zip(rows, poses.T.tolist(), strict=True):
        row |= dict(zip(("Tx", "Ty", "Tz"), place, strict=True))
    units = {"": "", "length": instance.units.length, "angle": instance.units.angle.value}
    columns = FIELDS.of("number")
    columns += [
        Field(key, f"{key} [{units['length']}]", "right", True, aligned=True, decimals=decimals)
        for key in ("Tx", "Ty", "Tz")
    ]
    for one in rotation:
        title = f"{one.key} [{units[one.unit]}]" if one.unit else ""
        columns.append(Field(one.key, title, "right", True, aligned=True, decimals=decimals))
        for row, cell in zip(rows, one.read(poses), strict=True):
            row[one.key] = float(cell)
    columns += [
        *FIELDS.of("chi_squared probability"),
        FIELDS["sigma_T"].but(title=f"± T [{units['length']}]"),
        FIELDS["sigma_turn"].but(title=f"± turn [{units['angle']}]"),
        FIELDS["fits"],
    ]
    for row in rows:
        row["chi_squared"] = round(float(f"{row['chi_squared']:.4g}"), _DECIMALS)
        for key in ("probability", "sigma_T"):
            row[key] = float(f"{row[key]:.2g}")
        row["sigma_turn"] = float(f"{row['sigma_turn']:.2g}")
    keys = [column.key for column in columns]
    rows = [{key: row[key] for key in keys} for row in rows]
    notes = ["± of one axis, the largest of three; of the platform's origin"]
    if not frame.is_identity:
        notes.append(f"poses are {frame.words}")
    return Result(columns, rows, instance.title, notes=notes, summary=fit.sentences, part="poses")


def _residuals(fit: PoseFit) -> list[Result]:
    """Return the residuals of the best pose."""
    if not fit.poses:
        return []
    best = fit.poses[0]
    names = [fit.numbers.names[k] for k in best.owners.tolist()]
    rows: list[dict[str, Any]] = [
        {
            "measured": name,
            "off": round(left, _DECIMALS),
            "studentised": None if size != size else round(size, _DECIMALS),
            "remarks": "large" if abs(size) > _LARGE else "",
        }
        for name, left, size in zip(
            names, best.residuals.tolist(), best.studentised.tolist(), strict=True
        )
    ]
    columns = [
        FIELDS["measured"],
        FIELDS["off"].but(decimals=_DECIMALS),
        FIELDS["studentised"].but(decimals=_DECIMALS),
        FIELDS["remarks"],
    ]
    notes = [
        "off: measured less fitted, at pose 1; studentised: over the deviation of that difference, "
        "empty where no other measurement checks it"
    ]
    return [Result(columns, rows, notes=notes, part="residuals")]


def check_options(*, fitting: bool, **given: object) -> None:
    """Raise for --sigma without --fit, and for options of the table of modes with it."""
    if not fitting:
        raise click.UsageError("--sigma says how exact the values are: give it with --fit")
    wrong = [f"--{name.replace('_', '-')}" for name, value in given.items() if value]
    if wrong:
        raise click.UsageError(f"{listed(wrong, 'and')}: not with --fit")


@click.command(cls=Command)
@click.argument("specs", metavar="SPEC...", nargs=-1, required=True)
@click.option(
    "--lines",
    "by_line",
    is_flag=True,
    help="SPEC has an instance in each line, as JSON: the default for files that end with .jsonl.",
)
@value_options
@click.option("--all", "everything", is_flag=True, help="Also show poses that are not real.")
@click.option(
    "--prove/--no-prove",
    default=None,
    help="--prove counts the poses of a special platform exactly, for any time, "
    "modulo two random primes. --no-prove never counts. By default poses are counted "
    "if that takes a few seconds at most.",
)
@seed_option("; the answer does not depend on it")
@jobs_option
@click.option(
    "--rotation",
    default="quaternion",
    show_default=True,
    metavar="FORM",
    help="Write rotations as quaternion, matrix, rotvec, or angles about axes: ZYX and the like "
    "about those of the platform, xyz about those of the base, PI, LinuxCNC or Symetrie.",
)
@decimals_option(None, 0, 17, ": positions and rotations, independently of the width")
@near_option("poses are sorted by their distance from it")
@pose_options
@filter_options
@click.option(
    "--reading",
    "readings",
    metavar="READING",
    multiple=True,
    help="The reading of one more sensor with its standard deviation, such as 'leg P1 B3 = 212.4 ± "
    "0.1' (or +-), in the units of SPEC. The mode that fits is marked. May be repeated.",
)
@click.option(
    "--fit",
    "fitting",
    is_flag=True,
    help="Take the values and all readings as measurements with errors: the least-squares pose of "
    "each mode, whether it fits, and which measurement is the outlier.",
)
@click.option(
    "--sigma",
    "sigmas",
    metavar="WHAT=NUMBER",
    multiple=True,
    help="Standard deviation of what is measured: value (distances), angle, or the number of a "
    "constraint; else `tolerance` in SPEC. With --fit; may be repeated.",
)
@click.option("--legend", is_flag=True, help="Explain the columns.")
@digits_option
@output_options(formats=(*FORMATS, LINES))
def command(o: Options) -> int:
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
    from dataclasses import replace

    from gspcli.cli.pose_tables import Shown
    from gspcli.solver import solve
    from gspcli.solver.results.columns import rotation_columns

    columns = rotation_columns(o.rotation)
    filters = FilterOptions(_parsed(o.where), o.within_limits, o.above)
    _check_usage(o.rotation, everything=o.everything)
    if are_many(o.specs, lines=o.by_line) or o.output.format == LINES:
        _refuse_alone(
            o.conventions, near=o.near, reading=o.readings, fit=o.fitting, legend=o.legend
        )
        documented = o.output.format == LINES
        how = _How(o.seed, o.prove, o.everything, o.digits, o.conventions, filters, documented)
        return solve_many(
            o.specs, partial(_solved, how), o.changes, o.jobs, o.output, lines=o.by_line
        )
    instance = load_instance(o.specs[0], o.changes)
    given = given_readings(o.readings, instance, repeated=o.fitting)
    frame = o.conventions.frame(instance)
    if o.fitting or o.sigmas:
        others = {"all": o.everything, "near": o.near, "digits": o.digits, "legend": o.legend}
        check_options(**others, **filters.options, prove=o.prove is not None, fitting=o.fitting)
        return show_fit(instance, given, o.sigmas, columns, o.decimals, frame, o.output)
    goal = _goal(o.near, o.conventions, instance, filtered=bool(filters.where))
    with working("solving"):
        result = solve(instance, seed=o.seed, jobs=o.jobs, prove=o.prove)
        result, left = filters.applied(result, o.conventions)
        chosen = _indices(result, everything=o.everything)
        shown = Shown(chosen, columns, o.decimals, frame=frame, left=left)
        if goal is not None:
            shown = _sorted(result, shown, *goal)
        if (fit := fitted(result, given)) is not None:
            shown = replace(shown, fits=fit.rows())
        proved = _refined(result, shown, o.digits) if o.digits is not None else []
    _show(result, shown, proved, fit, o.output, everything=o.everything, legend=o.legend)
    if result.home is not None and result.home.doubt and not o.changes.given:
        say(f"warning: {result.home.doubt}")
    return _complained(result, fit)


def _show(
    result: SolveResult,
    shown: Shown,
    proved: Sequence[dict[str, Any] | None],
    fit: ReadingFit | None,
    output: Output,
    *,
    everything: bool,
    legend: bool,
) -> None:
    """Write the poses, with the digits and readings that were asked for."""
    from gspcli.cli.pose_tables import data_table, lone_tables, pose_tables, summary

    with working("solving"):
        contradicting = _contradicting(result)
        lines = [*summary(result, contradicting=contradicting), *shown.left_sentences(result)]
    lines += [] if fit is None else [fit.sentence]
    if output.format in _READABLE:
        notes = _notes(result, shown, everything=everything, legend=legend)
        tables = pose_tables(result, shown, summary=lines, notes=notes)
        emit(output, [*tables, *lone_tables(result, shown), *_digits_of(shown, proved)])
    else:
        flat = [digit_cells(pose or {}) for pose in proved]
        table = data_table(result, shown, flat, imaginary=everything, summary=lines)
        found = result, shown, proved, contradicting, fit
        document = _document(*found, everything=everything) if output.format == "json" else None
        emit(output, table, document=document)


def _complained(result: SolveResult, fit: ReadingFit | None) -> int:
    """Raise the error that sets the exit code, about the poses or the readings; else return 0."""
    _complain(result)
    if fit is not None:
        refuse_misfit(fit)
    return 0


def _indices(result: SolveResult, *, everything: bool) -> Sequence[int]:
    """Return which poses are shown: the real ones are the first."""
    poses = range(len(result.R) if everything else result.counts.real)
    return [k for k in poses if k not in result.left_out] if result.left_out else poses


def _refuse_alone(conventions: PoseConventions, **options: object) -> None:
    """Raise for options that are about the table of one instance."""
    given = [f"--{name}" for name, value in options.items() if value]
    given += [name for name in conventions.options if name != RELATIVE]
    if given:
        raise click.UsageError(f"{listed(given, 'and')}: for one SPEC and its table only")


@dataclass(frozen=True)
class _How:
    """How each of many instances is solved, and whether its document is asked for."""

    seed: int
    prove: bool | None
    everything: bool
    digits: int | None
    conventions: PoseConventions
    filters: FilterOptions
    documented: bool


def _solved(how: _How, instance: Instance) -> tuple[SolveResult, dict[str, Any], GspError | None]:
    """Return the result of one of many instances, its document, and its error."""
    from gspcli.cli.pose_tables import Shown
    from gspcli.solver import solve

    frame = how.conventions.frame(instance)
    found = solve(instance, seed=how.seed, jobs=1, prove=how.prove)
    result, left = how.filters.applied(found, how.conventions)
    document: dict[str, Any] = {}
    if how.documented:
        every = how.everything
        chosen = _indices(result, everything=every)
        shown = Shown(chosen, (), None, frame=frame, left=left)
        proved = _refined(result, shown, how.digits) if how.digits is not None else []
        contradicting = _contradicting(result)
        document = _document(result, shown, proved, contradicting, None, everything=every)
    try:
        _complain(result)
    except GspError as error:
        return result, document, error
    return result, document, None


def _sorted(result: SolveResult, shown: Shown, R: Any, T: Any) -> Shown:
    """Return the poses by their distance from one, and the distances."""
    from dataclasses import replace

    import numpy as np

    from gspcli.geometry.home_mode import distances

    chosen = np.array([k for k in shown.indices if result.real[k]], dtype=int)
    moved, turned = distances(result.R[chosen].real, result.T[chosen].real, R, T)
    order = np.argsort(np.hypot(moved, result.arrangement.length * turned), kind="stable")
    pairs = np.stack((moved, turned / result.arrangement.in_radians), axis=1)[order]
    return replace(
        shown,
        indices=chosen[order].tolist(),
        distances=[(length, angle) for length, angle in pairs.tolist()],
    )


def _check_usage(rotation: str, *, everything: bool) -> None:
    """Raise if rotations that are not real are shown and cannot be written so."""
    from gspcli.geometry.euler import MAKERS

    if rotation.strip().lower() in MAKERS:
        order_named("--rotation", rotation)
    if everything and rotation not in ("quaternion", "matrix"):
        raise click.UsageError(
            f"--rotation {rotation} cannot write poses that are not real: leave out --all"
        )


def _goal(
    near: GivenPose | None, conventions: PoseConventions, instance: Instance, *, filtered: bool
) -> tuple[Any, Any] | None:
    """Return the pose that others are compared with."""
    if near is not None:
        return near.read(conventions.form(instance))
    if (conventions.euler or conventions.pivot) and not filtered:
        raise click.UsageError(
            "--euler and --pivot say how --near and --where are read: give one of them, too"
        )
    return None


def _notes(result: SolveResult, shown: Shown, *, everything: bool, legend: bool) -> list[str]:
    """Return the notes below the poses."""
    from gspcli.cli.pose_tables import LEGEND, remarks

    notes = [*frame_note(shown.frame), *remarks(result, shown.numbers)]
    if not everything and (others := len(result.R) - result.counts.real):
        notes.append(f"{others} more are not real: --all shows them")
    if shown.distances is not None:
        notes.append("nearest: by the translation and the turn times the platform's size")
    return [*notes, *(LEGEND if legend else ())]


def _contradicting(result: SolveResult) -> list[int]:
    """Return the numbers of constraints that contradict each other, if that is why none is real."""
    if result.counts.real or result.verdict != "complete":
        return []
    from gspcli.reality.contradiction import contradiction

    return [k + 1 for k in contradiction(result.arrangement)]


def _document(
    result: SolveResult,
    shown: Shown,
    proved: Sequence[dict[str, Any] | None],
    contradicting: Sequence[int],
    fit: ReadingFit | None,
    *,
    everything: bool,
) -> dict[str, Any]:
    """Return the result for JSON, with the digits and readings that were asked for."""
    from gspcli.cli.pose_tables import add_expressed

    document = result.to_json(everything=everything)
    entries = [document["solutions"][k] for k in shown.indices]
    for entry, pose in zip(entries, proved, strict=False):
        entry["refined"] = pose
    for entry, (length, angle) in zip(entries, shown.distances or (), strict=False):
        entry["distance"] = {"translation": length, "turn": angle}
    if not shown.frame.is_identity:
        add_expressed(document, result, shown)
    if shown.left is not None:
        from gspcli.motion.poses.mode_filters import left_out_json

        document["left_out"] = left_out_json(shown.left)
    document["solutions"] = entries
    if contradicting:
        document["contradicting"] = list(contradicting)
    if fit is not None:
        add_fit(document, shown, fit)
    return document


def _refined(result: SolveResult, shown: Shown, digits: int) -> list[dict[str, Any] | None]:
    """Return each pose with proved digits; None for those that cannot be certified."""
    from gspcli.certification import certify

    indices = list(shown.indices)
    if not indices:
        return []
    proved = certify(
        result.instance, result.R[indices], result.T[indices], sides=result.sides[indices]
    )
    return [
        refined(result.instance, certificate, digits) if certificate.certified else None
        for certificate in proved
    ]


def _digits_of(shown: Shown, proved: Sequence[dict[str, Any] | None]) -> list[Result]:
    """Return the table of the digits that are proved, if there are any."""
    if not any(proved):
        return []
    rows = [
        {"number": number, **digit_cells(pose or {})}
        for number, pose in zip(shown.numbers, proved, strict=True)
    ]
    return [digit_table(rows)]


def _complain(result: SolveResult) -> None:
    """Raise the error that sets the exit code, if there is one."""
    from gspcli.cli.pose_tables import fixed

    counts = result.counts
    if result.verdict == "infinite":
        message = "the poses are infinitely many"
        if count := len(result.lone.R):
            alone = f"{count} are real" if count > 1 else "one is real"
            raise NotFiniteError(f"{message} over the complex numbers; {alone}, and cannot move")
        if fixed(result):
            message += " in another component; from the isolated real ones the platform cannot move"
            if result.motions:
                dimension = result.motions[0].dimension
                message += (
                    f"\n(numerical evidence: that component has local dimension {dimension}; "
                    "--format json has a sample)"
                )
            raise NotFiniteError(message)
        for motion in result.motions[:1]:
            how = "the platform can move" if motion.real else "over the complex numbers"
            message += (
                f": {how}, with local dimension {motion.dimension}\n"
                "(numerical evidence; --format json has sample motions)"
            )
        raise NotFiniteError(message)
    if result.account.lost:
        from gspcli.spec import out_of_proportion

        lost, expected = result.account.lost, result.expected
        message = f"{lost} of {expected} expected solutions could not be classified"
        if disproportion := out_of_proportion(result.instance):
            raise IncompleteError(f"{message}:\n{disproportion}")
        message += (
            ": the platform is in or near a special position\n"
            "try --prove, another --seed, or change a value a little with --set and compare"
        )
        raise IncompleteError(message)
    if result.proof is None and counts.certified < counts.found:
        missing = counts.found - counts.certified
        raise IncompleteError(f"{missing} of {counts.found} poses could not be certified")


Function = TypeVar("Function", bound=Callable[..., Any])
