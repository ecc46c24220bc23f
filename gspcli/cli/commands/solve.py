"""`gsp solve`: every pose of a platform given in a file."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, islice
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gspcli.cli.options import (
    FORMATS,
    RELATIVE,
    Command,
    Options,
    decimals_option,
    jobs_option,
    needs,
    order_named,
    output_options,
    seed_option,
    value_options,
    without,
)
from gspcli.cli.pose_options import frame_note, near_option, pose_options
from gspcli.cli.pose_tables import (
    Shown,
    add_expressed,
    data_table,
    digit_cells,
    digit_table,
    digits_option,
    fixed,
    lone_tables,
    pose_field,
    pose_tables,
    refined,
    remarks,
    summary,
)
from gspcli.cli.render import emit, write
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import spec_source, standard_deviations
from gspcli.cli.streams import progress, say, working
from gspcli.errors import (
    ArgumentError,
    CheckFailed,
    GspError,
    IncompleteError,
    Mistake,
    NotFiniteError,
    SpecError,
)
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import MAKERS
from gspcli.solver.result import TRANSLATION, PoseColumn, expressed, rotation_columns
from gspcli.wording import listed, named
from gspcli.wording import shown as quoted

if TYPE_CHECKING:
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion.poses.mode_filters import Condition
    from gspcli.sensing import PoseFit, ReadingFit
    from gspcli.sensing.sensor_kinds import SensorReading
    from gspcli.solver import SolveResult

FIELDS = Fields("solve")

#: The ends of the names of files with an instance in each line, and the format of such answers.
LINE_SUFFIXES = (".jsonl", ".ndjson")
LINES = "jsonl"
#: This process solves this many instances before it starts others: a start takes as long as solving
#: them.
_HERE_FIRST = 16
_COLUMNS = FIELDS.of("instance name type real found certified verdict exit_code message")
#: Decimals of residuals and of chi-squared: further decimals are rounding errors.
_DECIMALS = 3
#: Residuals larger than this many deviations are marked.
_LARGE = 3.0


def _conditions(_: click.Context, __: click.Parameter, texts: Sequence[str]) -> list[Condition]:
    """Return the conditions of `--where`."""
    if not texts:
        return []
    from gspcli.motion.poses.mode_filters import parse_conditions

    try:
        return [one for text in texts for one in parse_conditions(text)]
    except ArgumentError as error:
        raise GspError(f"--where: {error}") from None


@click.command(cls=Command)
@without("--fit", "--all", "--near", "--digits", "--prove", "--where", "--within-limits", "--above")
@needs("--sigma", "--fit")
@needs("--euler", "--near", "--where")
@needs("--pivot", "--near", "--where")
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
@click.option(
    "--where",
    metavar="CONDITION",
    multiple=True,
    callback=_conditions,
    help="List only real poses with this, such as 'z>0, rx<=45': x, y, z, and rx, ry, rz in "
    "the order of --euler or ZYX; may be repeated.",
)
@click.option(
    "--within-limits", is_flag=True, help="List only real poses within all ranges and cones."
)
@click.option(
    "--above",
    is_flag=True,
    help="List only real poses with the platform above its base: on the side of home, or of z.",
)
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
    columns = rotation_columns(o.rotation)
    if o.rotation.strip().lower() in MAKERS:
        order_named("--rotation", o.rotation)
    if o.everything and o.rotation not in ("quaternion", "matrix"):
        raise click.UsageError(
            f"--rotation {o.rotation} cannot write poses that are not real: leave out --all"
        )
    if len(o.specs) > 1 or o.output.format == LINES or _has_lines(o, o.specs[0]):
        return _solve_many(o)
    from gspcli.solver import solve

    o.spec = o.specs[0]
    readings, frame, fit = _readings(o), o.frame_of(o.instance), None
    if o.fitting:
        return _show_fit(o, readings, columns, frame)
    goal = None if o.near is None else o.near.read(o.form)
    with working("solving"):
        result, left = _filtered(solve(o.instance, seed=o.seed, jobs=o.jobs, prove=o.prove), o)
        shown = Shown(_indices(result, o), columns, o.decimals, frame=frame, left=left)
        if goal is not None:
            shown = _sorted(result, shown, *goal)
        if readings:
            from gspcli.sensing import fit_readings

            fit = fit_readings(result, readings)
            shown = replace(shown, fits=fit.rows())
        proved = _refined(result, shown, o.digits)
        contradicting = _contradicting(result)
    lines = [*summary(result, contradicting=contradicting), *shown.left_sentences(result)]
    lines += [] if fit is None else [fit.sentence]
    if o.output.format == "json":
        document = _document(result, shown, proved, contradicting, fit, everything=o.everything)
        emit(o.output, (), document=document)
    elif o.output.format == "csv":
        flat = [digit_cells(pose or {}) for pose in proved]
        emit(o.output, data_table(result, shown, flat, imaginary=o.everything, summary=lines))
    else:
        notes = [*frame_note(frame), *remarks(result, shown.numbers)]
        if not o.everything and (others := len(result.R) - result.counts.real):
            notes.append(f"{others} more are not real: --all shows them")
        if goal is not None:
            notes.append("nearest: by the translation and the turn times the platform's size")
        tables = pose_tables(result, shown, summary=lines, notes=notes)
        rows = [
            {"number": number, **digit_cells(pose or {})}
            for number, pose in zip(shown.numbers, proved, strict=bool(proved))
        ]
        digits = [digit_table(rows)] if any(proved) else []
        emit(o.output, [*tables, *lone_tables(result, shown), *digits])
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


def _readings(o: Options) -> list[SensorReading]:
    """Return the readings that are given; with `--fit` they may be those of constraints, too."""
    from gspcli.sensing.sensor_kinds import parse_reading

    found = []
    for text in o.readings:
        try:
            found.append(parse_reading(text, o.instance, repeated=o.fitting))
        except GspError as error:
            raise GspError(f"--reading {quoted(text)}, {error}") from None
    return found


def _filtered(result: SolveResult, o: Options) -> tuple[SolveResult, dict[str, list[int]] | None]:
    """Return the result without the poses that are left out as home, and their numbers."""
    if not (o.where or o.within_limits or o.above):
        return result, None
    from gspcli.motion.poses.mode_filters import ModeFilter

    form = o.form_of(result.instance)
    asked = ModeFilter(o.where, o.within_limits, o.above, form.pivot_frame, form.euler or "ZYX")
    try:
        left = asked.left_out(result)
    except ArgumentError as error:
        raise GspError(f"--{error.where.replace('_', '-')}: {error.message}") from None
    return replace(result, left_out=tuple(sorted(k - 1 for ks in left.values() for k in ks))), left


def _indices(result: SolveResult, o: Options) -> Sequence[int]:
    """Return which poses are shown: the real ones are the first."""
    poses = range(len(result.R) if o.everything else result.counts.real)
    return [k for k in poses if k not in result.left_out] if result.left_out else poses


def _sorted(result: SolveResult, shown: Shown, R: Any, T: Any) -> Shown:
    """Return the poses by their distance from one, and the distances."""
    from gspcli.geometry.home_mode import distances

    chosen = np.array([k for k in shown.indices if result.real[k]], dtype=int)
    moved, turned = distances(result.R[chosen].real, result.T[chosen].real, R, T)
    order = np.argsort(np.hypot(moved, result.arrangement.length * turned), kind="stable")
    pairs = np.stack((moved, turned / result.arrangement.in_radians), axis=1)[order]
    return replace(
        shown, indices=chosen[order].tolist(), distances=list(map(tuple, pairs.tolist()))
    )


def _contradicting(result: SolveResult) -> list[int]:
    """Return the numbers of constraints that contradict each other, if that is why none is real."""
    if result.counts.real or result.verdict != "complete":
        return []
    from gspcli.reality.contradiction import contradiction

    return [k + 1 for k in contradiction(result.arrangement)]


def _refined(result: SolveResult, shown: Shown, digits: int | None) -> list[dict[str, Any] | None]:
    """Return each pose with proved digits; None for those that cannot be certified."""
    indices = list(shown.indices)
    if digits is None or not indices:
        return []
    from gspcli.certification import certify

    proved = certify(
        result.instance, result.R[indices], result.T[indices], sides=result.sides[indices]
    )
    return [refined(result.instance, one, digits) if one.certified else None for one in proved]


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
        document |= fit.to_json()
        for entry, index in zip(entries, shown.indices, strict=True):
            if index < len(fit.off) and fit.result.counts.real:
                entry |= fit.of_mode(index)
    return document


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


def _has_lines(o: Options, spec: str) -> bool:
    """Return whether a file has an instance in each line."""
    return o.by_line or spec.lower().endswith(LINE_SUFFIXES)


def _solve_many(o: Options) -> int:
    """Solve instances one after the other; write an answer for each, in their order.

    Answers in JSON, one a line, are written as soon as they are known. An error of one instance is
    part of its answer, and the others are solved.
    """
    alone = {"--near": o.near, "--reading": o.readings, "--fit": o.fitting}
    given = [name for name, value in alone.items() if value]
    given += [name for name in o.conventions if name != RELATIVE]
    if given:
        raise click.UsageError(f"{listed(given, 'and')}: for one SPEC and its table only")
    if o.specs.count("-") > 1:
        raise GspError("standard input can be one SPEC only: - is given more than once")
    by_line = [_has_lines(o, spec) for spec in o.specs]
    sources = chain.from_iterable(
        _lines_of(spec) if lines else [(spec, None)]
        for spec, lines in zip(o.specs, by_line, strict=True)
    )
    answers = _answers(sources, o)
    as_lines = o.output.format == LINES
    streamed = as_lines and o.output.path is None
    if not (streamed and sys.stdout.isatty()):
        # A progress bar would be printed between the lines.
        total = None if any(by_line) else len(o.specs)
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
        emit(o.output, Result(_COLUMNS, rows, notes=[said]))
    elif not streamed:
        write(o.output, "".join(texts))
    if as_lines and max(codes):
        say(said)
    return max(codes)


def _answers(
    sources: Iterator[tuple[str, str | None]], o: Options
) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Yield the answers in the order of the sources."""
    from gspcli.workers import Workers

    answer = partial(_answer, o)
    yield from map(answer, islice(sources, _HERE_FIRST))
    if more := list(islice(sources, 1)):
        yield from Workers(o.jobs).in_order(answer, chain(more, sources))


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


def _answer(o: Options, source: tuple[str, str | None]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the row and the document of one instance; its error, if any, is part of both.

    A source is the name of an instance, and its text; None if it is the name of a file.
    """
    from gspcli.solver import solve

    name, text = source
    row: dict[str, Any] = {"verdict": "no answer"}
    document: dict[str, Any] = {}
    said: dict[str, Any] = {"instance": name, "exit_code": 0, "message": None}
    try:
        instance = o.changes.of(_instance(name, text))
        frame = o.frame_of(instance)
        found = solve(instance, seed=o.seed, jobs=1, prove=o.prove)
        result, left = _filtered(found, o)
        if o.output.format == LINES:
            shown = Shown(_indices(result, o), (), None, frame=frame, left=left)
            more = _refined(result, shown, o.digits), _contradicting(result)
            document = _document(result, shown, *more, None, everything=o.everything)
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
        raise SpecError([Mistake(None, "", f"{name}: expected text in UTF-8")]) from error
    return read_text(text, name=name).instance


def _show_fit(
    o: Options,
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
    if fit.poses and o.output.format != "csv":
        tables.append(_residuals(fit))
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
