"""`gsp solve`: every pose of a platform given in a file."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.digits import digit_cells, digit_table, digits_option, refined
from gspcli.cli.filter_options import FilterOptions, filter_options
from gspcli.cli.many_instances import LINES, are_many, solve_many
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import decimals_option, seed_option
from gspcli.cli.output import FORMATS, Output, Table, emit, output_options
from gspcli.cli.pose_fit import check_options, show_fit
from gspcli.cli.pose_options import (
    RELATIVE,
    PoseConventions,
    frame_note,
    order_named,
    pose_options,
)
from gspcli.cli.pose_type import GivenPose, near_option
from gspcli.cli.progress_bars import working
from gspcli.cli.reading_options import add_fit, fitted, given_readings, refuse_misfit
from gspcli.cli.value_options import Changes, value_options
from gspcli.cli.worker_options import jobs_option
from gspcli.errors import GspError, IncompleteError, NotFiniteError
from gspcli.records import dataclass
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.cli.pose_tables import Shown
    from gspcli.geometry.instance import Instance
    from gspcli.sensing import ReadingFit
    from gspcli.solver import SolveResult

#: Formats for people.
_READABLE = ("table", "markdown", "latex")


@click.command()
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
    "--no-certify",
    is_flag=True,
    help="Do not prove what is found. Ignored and deprecated: every pose is proved.",
)
@click.option(
    "--prove/--no-prove",
    default=None,
    help="--prove counts the poses of a special platform exactly, for any time, and tries to make "
    "a proof up to a random prime certain. --no-prove never counts. By default poses are counted "
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
def command(
    specs: tuple[str, ...],
    by_line: bool,
    changes: Changes,
    everything: bool,
    no_certify: bool,
    prove: bool | None,
    seed: int,
    jobs: int,
    rotation: str,
    decimals: int | None,
    near: GivenPose | None,
    conventions: PoseConventions,
    filters: FilterOptions,
    readings: tuple[str, ...],
    fitting: bool,
    sigmas: tuple[str, ...],
    legend: bool,
    digits: int | None,
    output: Output,
) -> int:
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

    columns = rotation_columns(rotation)
    _check_usage(rotation, everything=everything, no_certify=no_certify)
    if are_many(specs, lines=by_line) or output.format == LINES:
        _refuse_alone(conventions, near=near, reading=readings, fit=fitting, legend=legend)
        documented = output.format == LINES
        how = _How(seed, prove, everything, digits, conventions, filters, documented)
        return solve_many(specs, partial(_solved, how), changes, jobs, output, lines=by_line)
    instance = load_instance(specs[0], changes)
    given = given_readings(readings, instance, repeated=fitting)
    frame = conventions.frame(instance)
    if fitting or sigmas:
        others = {"all": everything, "near": near, "digits": digits, "legend": legend}
        check_options(**others, **filters.options, prove=prove is not None, fitting=fitting)
        return show_fit(instance, given, sigmas, columns, decimals, frame, output)
    goal = _goal(near, conventions, instance, filtered=bool(filters.where))
    with working("solving"):
        result = solve(instance, seed=seed, jobs=jobs, prove=prove)
        result, left = filters.applied(result, conventions)
        chosen = _indices(result, everything=everything)
        shown = Shown(chosen, columns, decimals, frame=frame, left=left)
        if goal is not None:
            shown = _sorted(result, shown, *goal)
        if (fit := fitted(result, given)) is not None:
            shown = replace(shown, fits=fit.rows())
        proved = _refined(result, shown, digits) if digits is not None else []
    _show(result, shown, proved, fit, output, everything=everything, legend=legend)
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
    from gspcli.cli.pose_tables import data_table, lone_tables, pose_tables
    from gspcli.cli.summary import summary

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
        message = f"{listed(given, 'and')}: for one SPEC and its table only"
        raise click.UsageError(message)


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


def _check_usage(rotation: str, *, everything: bool, no_certify: bool) -> None:
    """Raise if rotations that are not real are shown and cannot be written so."""
    from gspcli.geometry.euler import MAKERS

    if rotation.strip().lower() in MAKERS:
        order_named("--rotation", rotation)
    if no_certify:
        click.echo("--no-certify is ignored: every pose is proved", err=True)
    if everything and rotation not in ("quaternion", "matrix"):
        message = f"--rotation {rotation} cannot write poses that are not real: leave out --all"
        raise click.UsageError(message)


def _goal(
    near: GivenPose | None, conventions: PoseConventions, instance: Instance, *, filtered: bool
) -> tuple[Any, Any] | None:
    """Return the pose that others are compared with."""
    if near is not None:
        return near.read(conventions.form(instance))
    if (conventions.euler or conventions.pivot) and not filtered:
        message = "--euler and --pivot say how --near and --where are read: give one of them, too"
        raise click.UsageError(message)
    return None


def _notes(result: SolveResult, shown: Shown, *, everything: bool, legend: bool) -> list[str]:
    """Return the notes below the poses."""
    from gspcli.cli.pose_tables import LEGEND
    from gspcli.cli.summary import remarks

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


def _digits_of(shown: Shown, proved: Sequence[dict[str, Any] | None]) -> list[Table]:
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
    from gspcli.cli.summary import fixed

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
        message = f"{missing} of {counts.found} poses could not be certified"
        raise IncompleteError(message)
