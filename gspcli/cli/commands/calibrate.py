"""`gsp calibrate`: from measured values and poses to the true numbers of a platform."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli import options
from gspcli.cli.pose_options import (
    column_options,
    frame_note,
    mode_option,
    one_mode,
    pose_options,
    text_of,
)
from gspcli.cli.render import emit, write
from gspcli.cli.requirements import measured_quantities, require_option, required
from gspcli.cli.result import POSE, Fields, Result, pose_columns
from gspcli.cli.specs import standard_deviations
from gspcli.cli.streams import say, working
from gspcli.errors import CheckFailed
from gspcli.wording import counted, listed, named

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.calibration import Calibration
    from gspcli.calibration import Options as FitOptions
    from gspcli.calibration.identifying import Identification
    from gspcli.calibration.planning import Plan
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Array, Instance
    from gspcli.motion.files.requirements import Requirement

FIELDS = Fields("calibrate")

#: The most poses of a plan. More poses take hours to choose, and determine the numbers hardly
#: better than as many random poses.
_MOST_PLANNED = 300


@click.command(cls=options.Command)
@options.exclusive("SPEC", "--from")
@options.without("--from", "--plan", "--target")
@options.needs("--mode", "--plan")
@options.needs("--require", "--plan")
@click.argument("spec", metavar="[SPEC]", required=False)
@click.argument("data", metavar="[DATA]", required=False)
@options.option(
    "--from LOG",
    "Instead of SPEC and DATA: find a hexapod from a log with legs and poses as columns.",
    name="log",
)
@options.option(
    "--sigma WHAT=NUMBER",
    "Standard deviation of what is measured: value, position (lengths), angle, rotation, "
    "inclination, crank (angles), slide; may be repeated.",
    name="sigmas",
    multiple=True,
)
@options.option(
    "--estimate WHAT",
    "Also estimate scales, frames (of device and target), or a number such as offset.2 or "
    "base.B1.slide.offset.",
    multiple=True,
)
@options.option(
    "--hold WHAT",
    "Keep as stated: offsets, platform, base, or such as platform.P1, base.H2, offset.3.",
    multiple=True,
)
@options.option(
    "--target NAME=X,Y,Z",
    "Where a point with columns NAME.x, NAME.y, NAME.z is in the platform's frame.",
    name="targets",
    multiple=True,
)
@options.option(
    "--robust", "Leave out numbers that are more than five deviations away, and name their rows."
)
@options.option(
    "--prior D",
    "How exactly the stated numbers are known, as a length.  [default: 1/200 of a typical length]",
    type=options.Positive(),
)
@options.option(
    "--hold-unknown",
    "Keep the numbers that DATA does not determine at their stated values, instead of refusing.",
)
@options.option("--accept", "Take the result even if DATA does not fit the machine.")
@options.option(
    "--plan",
    "Plan N poses to measure, in addition to those of DATA if it is given.",
    type=options.Whole(1, _MOST_PLANNED),
)
@mode_option("about which poses are planned.  [default: home]")
@require_option("condition<=50, clearance>=0.5", "for rows of --plan")
@options.seed_option(": of --plan")
@pose_options
@column_options
@options.output_options(formats=(*options.FORMATS, "yaml", *options.DRAWINGS))
def command(o: options.Options) -> None:
    """Find the true numbers of a platform from measured values and poses.

    The coordinates of all points, lines and planes and the offsets of the values are found by
    least squares, together with the poses, since everything that is measured has errors. The
    table has the stated number, the one found, its standard deviation sigma, and the change
    over sigma.

    SPEC is the platform as stated, DATA a CSV file with a heading, - for standard input. Any
    cell of DATA may be blank. Its columns are:

    \b
      1 ... 6             what the machine reads
      x, y, z, rotation   the pose as `gsp measure` reads it
      P1.x, P1.y, P1.z    position of point or --target P1
      incl.x, incl.y      angles of x, y above the horizontal
      crank.B1, slide.B1  what a drive reads
      t                   a name of the row

    --sigma states the errors of what is measured; chi-squared should then be near its degrees
    of freedom. Without --sigma the scatter of DATA gives them. With --sigma position=0 --sigma
    rotation=0 poses are exact. Numbers that DATA does not determine are refused with exit code
    4; the message says what to measure.

    If DATA does not fit the machine, the first line says so and names the probable mistake: a unit,
    columns that are exchanged, rotations that are transposed. Then the exit code is 1 and no
    instance file is written, unless --accept is given.

    With -o FILE.yaml the result is an instance file with `offset` and `scale` at constraints, which
    every command uses. JSON has the covariance; a picture shows the residuals.

    --plan N fits nothing. It chooses N poses within ranges and cones (and --require) whose
    measurement determines the numbers best (D-optimal), and states how exactly each number will be
    known. Where cranks or slides drive the machine the plan has their readings.

    --from LOG needs no SPEC. LOG has the columns 1 ... 6 (lengths of legs from joint to joint), x y
    z and a rotation, of at least 18 poses. Order, sense and unit of angles and units of lengths are
    found by trying; the output says how well they fit, and which others fit as well. --estimate
    offsets also finds a constant that is to be added to each length. The origin of the platform's
    frame is the point whose position LOG has, unless --pivot states its coordinates.

    \b
    Examples:
      gsp calibrate machine.yaml measured.csv --sigma value=0.002 \\
        --sigma position=0.005 --sigma rotation=0.001 --robust
      gsp calibrate machine.yaml measured.csv -o calibrated.yaml
      gsp calibrate machine.yaml measured.csv -o residuals.svg
      gsp calibrate machine.yaml tracker.csv --estimate frames --robust
      gsp calibrate machine.yaml --plan 12 -o poses.csv
      gsp calibrate machine.yaml --plan 12 --require "condition<=50"
      gsp calibrate machine.yaml measured.csv --plan 6
      gsp calibrate --from controller-log.csv -o machine.yaml
    """
    if o.log is None and o.spec is None:
        raise click.UsageError("give SPEC and DATA, or --from LOG without a file to start from")
    if o.log is None and o.data is None and o.plan is None:
        raise click.UsageError("give DATA, or --plan N for which poses to measure")
    if o.plan is not None and o.output.format in ("yaml", *options.DRAWINGS):
        formats = ", ".join(options.FORMATS)
        wrong = f"a plan cannot be written as {o.output.format}: use one of {formats}"
        raise click.UsageError(wrong)
    from gspcli.calibration import Options as FitOptions
    from gspcli.calibration import calibrate_rows
    from gspcli.calibration.logs import read_measurements, targets_of

    noise = standard_deviations(o.sigmas)
    settings = FitOptions(o.estimate, o.hold, o.robust, o.prior, o.hold_unknown)
    if o.log is not None:
        _identify(o, noise, settings)
        return
    places, seen = targets_of(o.targets), None
    if o.data is not None:
        seen = read_measurements(*text_of(o.data), o.instance, o.form, places)
    if o.plan is not None:
        from gspcli.calibration.planning import planned

        requirements = required(o.require)
        allowed = partial(_allowed, o.instance, requirements) if requirements else None
        _, R, T = one_mode(o.instance, o.mode)
        given = {"sigma": noise, "options": settings, "seed": o.seed, "allowed": allowed}
        with working("choosing poses"):
            plan = planned(o.instance, o.plan, R[0], T[0], seen=seen, **given)
        emit(o.output, plan_table(plan, o.form.frame), document=_document(plan))
        return
    assert seen is not None
    with working("fitting"):
        result = calibrate_rows(o.instance, seen, noise, settings)
    _show(o, result, result)
    if result.doubts and not o.accept:
        cause = f"\n{result.cause}" if result.cause else ""
        robust = "" if result.options.robust else ", or try --robust"
        raise CheckFailed(
            f"the data do not fit the machine: {result.doubts[0]}{cause}\n"
            f"look for wrong rows and columns (-o FILE.svg shows residuals){robust}; --accept "
            "takes the result unchanged"
        )


def _document(found: Calibration | Identification | Plan) -> dict[str, Any]:
    return {"schema": "gsp.calibrate/1", **found.to_json()}


def _identify(o: options.Options, noise: dict[str, float], settings: FitOptions) -> None:
    """Find a hexapod from a log, and write its numbers, its instance file or the residuals."""
    import numpy as np

    from gspcli.calibration.identifying import identify_log
    from gspcli.calibration.logs import read_log

    form = o.form_of(None)
    log = read_log(*text_of(o.log), form.ignore, form.columns)
    with working("finding the machine"):
        found = identify_log(log, form.euler, np.array(form.pivot), noise, settings)
    _show(o, found, found.calibration, found.sentences)
    if found.doubts and not o.accept:
        raise CheckFailed(
            f"the log does not fit a machine with six legs: {found.doubts[0]}\n"
            "look for wrong rows, or try --robust; --accept takes the result unchanged"
        )


def _show(
    o: options.Options,
    found: Calibration | Identification,
    result: Calibration,
    remarks: Sequence[str] | None = None,
) -> None:
    """Write the new numbers, the residuals or the table of both; of a log also the remarks."""
    if o.output.format == "yaml":
        from gspcli.calibration.calibrating import calibrated_text

        comments = [] if remarks is None else [f"from {named(o.log)}", *remarks]
        if o.accept or not found.doubts:
            write(o.output, calibrated_text(result, comments))
    elif o.output.format in options.DRAWINGS:
        from gspcli.pictures.charts import residual_chart

        write(o.output, residual_chart(result, o.output.format))
    else:
        emit(o.output, calibration_table(result, remarks), document=_document(found))
        return
    for sentence in remarks or ():
        say(sentence)


def _allowed(
    instance: Instance, requirements: list[Requirement], R: Array, T: Array
) -> NDArray[np.bool_]:
    """Return which poses keep what is required."""
    from gspcli.motion.files.requirements import keeping

    return keeping(requirements, measured_quantities(instance, requirements, R, T))


def calibration_table(result: Calibration, remarks: Sequence[str] | None = None) -> Result:
    """Return the numbers found beside those stated; of a log, with `remarks`, none are stated."""
    units, rows = result.stated.units, []
    numbers = (result.before.tolist(), result.after.tolist(), result.sigma.tolist())
    for name, before, after, sigma in zip(result.names, *numbers, strict=True):
        row = {"number": name, "stated": before, "found": after, "sigma": float(f"{sigma:.3g}")}
        row["change/sigma"] = float(f"{(after - before) / sigma:.4g}") if sigma > 0 else None
        rows.append(row)
    keys = "number found sigma" if remarks is not None else "number stated found sigma change/sigma"
    note = f"lengths in {units.length}, angles in {units.angle.value}; scales and directions plain"
    summary = [*(remarks or ()), *_summary(result)]
    return Result(FIELDS.of(keys), rows, result.stated.title, [note], summary)


def _summary(result: Calibration) -> list[str]:
    """Return the result in sentences."""
    import numpy as np

    from gspcli.calibration.calibrating import quantile

    chi, freedom = result.chi_squared, result.freedom
    lines = [f"the data do not fit: {doubt}" for doubt in result.doubts]
    if result.cause:
        lines.append(result.cause)
    numbers = counted(len(result.names), "number")
    lines.append(f"{counted(len(result.seen), 'row')}, {numbers} found")
    if freedom <= 0:
        lines.append("as many numbers are found as were measured: their errors are not known")
    elif result.scatter == 1.0:
        lines.append(
            f"chi-squared {chi:.4g} of {freedom} degrees of freedom, "
            f"between {quantile(freedom, -1.96):.4g} and {quantile(freedom, 1.96):.4g} in 95 %"
        )
    else:
        noise = f"{result.noise.value * result.scatter:.2g} {result.stated.units.length}"
        if result.seen.rods.all():
            # Nothing is read but drives.
            noise = _noise_of_drives(result)
        of = f"({freedom} degrees of freedom)"
        lines.append(f"the noise is not stated: {noise} by the scatter {of}")
    if result.outliers.any():
        rows = [result.seen.lines[k] for k in np.flatnonzero(result.outliers.any(axis=1))]
        where = f"in {'row' if len(rows) == 1 else 'rows'} {listed(rows, 'and')}"
        numbers = counted(int(result.outliers.sum()), "number")
        lines.append(f"{numbers} left out, more than 5 sigma away: {where}")
    if result.unknowns.missing:
        what = counted(result.unknowns.missing, "direction")
        which = "; ".join(result.unknowns.sentences)
        lines.append(f"{what} not determined by the data, kept as stated: {which}")
    if result.repeated:
        lines.append(
            f"{counted(result.repeated, 'row')} with the same numbers as another: each counts as "
            "measured again, so that deviations are too small if they are copies"
        )
    if result.home:
        lines.append(result.home)
    if result.unknowns.frames:
        lines.append("the frames of base and platform are fitted to those stated")
    if result.worst is not None:
        row, left, moved = result.worst
        rest = result.without_worst[1].freedom if result.without_worst else 0
        name = result.seen.lines[row]
        line = f"worst row: {name if name == str(row + 1) else f't = {name}'}"
        if result.scatter == 1.0:
            line += f", {result.rows[row]:.4g} of chi-squared ({left:.4g} of {rest} without it)"
        lines.append(f"{line}; left out, no number moves by more than {moved:.2g} sigma")
    return lines


def _noise_of_drives(result: Calibration) -> str:
    """Return the deviations of the readings of cranks and slides by the scatter."""
    units, sorts = result.stated.units, {drive.sort for drive in result.fit.model.drives}
    crank = result.noise.crank / units.angle.in_radians * result.scatter
    slide = result.noise.slide * result.scatter
    parts = {
        "crank": f"{crank:.2g} {units.angle.value} of cranks",
        "slide": f"{slide:.2g} {units.length} of slides",
    }
    return listed([said for sort, said in parts.items() if sort in sorts], "and")


def plan_table(plan: Plan, frame: PoseFrame) -> Result:
    """Return poses to measure, as expressed in a frame, with what the machine reads there."""
    import numpy as np

    machine, instance = plan.machine, plan.machine.instance
    titles = {
        str(k): f"{k} {row.kind.name}"
        for k, row in enumerate(instance.constraints, 1)
        if not machine.driven[k - 1]
    } | dict.fromkeys(plan.drives, "")
    columns = FIELDS.of("t") + pose_columns(machine.stated_arrangement.length)
    columns += [FIELDS["1…6"].but(key=key, title=title) for key, title in titles.items()]
    numbers = np.column_stack((plan.expressed(frame), plan.readings, *plan.drives.values()))
    keys = (*POSE, *map(str, range(1, 7)), *plan.drives)
    rows = [
        {"t": k, **dict(zip(keys, row, strict=True))} for k, row in enumerate(numbers.tolist(), 1)
    ]
    note = f"{listed(titles, 'and')} are readings with the geometry as stated: "
    notes = [f"{note}replace them by what is read", *frame_note(frame)]
    return Result(columns, rows, instance.title, notes, plan.sentences)
