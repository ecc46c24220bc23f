"""`gsp calibrate`: from measured values and poses to the true numbers of a platform."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import (
    DRAWINGS,
    FORMATS,
    Command,
    Options,
    Positive,
    Whole,
    output_options,
    seed_option,
)
from gspcli.cli.pose_options import (
    Mode,
    column_options,
    frame_note,
    mode_option,
    pose_options,
    text_of,
)
from gspcli.cli.render import Output, emit, write
from gspcli.cli.requirements import measured_quantities, require_option, required
from gspcli.cli.result import Field, Fields, Result, pose_columns
from gspcli.cli.specs import standard_deviations
from gspcli.cli.streams import working
from gspcli.errors import CheckFailed
from gspcli.wording import counted, listed, named

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.calibration import Calibration
    from gspcli.calibration import Options as FitOptions
    from gspcli.calibration.measurements import Measurements
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion.files.requirements import Requirement

    Array = NDArray[np.float64]
    from gspcli.calibration.planning import Plan
    from gspcli.motion import PoseFormat

FIELDS = Fields("calibrate")

#: The most poses of a plan. More poses take hours to choose, and determine the numbers hardly
#: better than as many random poses.
_MOST_PLANNED = 300


@click.command(cls=Command)
@click.argument("spec", metavar="[SPEC]", required=False)
@click.argument("data", metavar="[DATA]", required=False)
@click.option(
    "--from",
    "log",
    metavar="LOG",
    help="Instead of SPEC and DATA: find a hexapod from a log with legs and poses as columns.",
)
@click.option(
    "--sigma",
    "sigmas",
    metavar="WHAT=NUMBER",
    multiple=True,
    help="Standard deviation of what is measured: value, position (lengths), angle, rotation, "
    "inclination, crank (angles), slide; may be repeated.",
)
@click.option(
    "--estimate",
    metavar="WHAT",
    multiple=True,
    help="Also estimate scales, frames (of device and target), or a number such as offset.2 or "
    "base.B1.slide.offset.",
)
@click.option(
    "--hold",
    metavar="WHAT",
    multiple=True,
    help="Keep as stated: offsets, platform, base, or such as platform.P1, base.H2, offset.3.",
)
@click.option(
    "--target",
    "targets",
    metavar="NAME=X,Y,Z",
    multiple=True,
    help="Where a point with columns NAME.x, NAME.y, NAME.z is in the platform's frame.",
)
@click.option(
    "--robust",
    is_flag=True,
    help="Leave out numbers that are more than five deviations away, and name their rows.",
)
@click.option(
    "--prior",
    type=Positive(),
    metavar="D",
    help="How exactly the stated numbers are known, as a length.  [default: 1/200 of a typical "
    "length]",
)
@click.option(
    "--hold-unknown",
    is_flag=True,
    help="Keep the numbers that DATA does not determine at their stated values, instead of "
    "refusing.",
)
@click.option(
    "--accept", is_flag=True, help="Take the result even if DATA does not fit the machine."
)
@click.option(
    "--plan",
    type=Whole(1, _MOST_PLANNED),
    metavar="N",
    help="Plan N poses to measure, in addition to those of DATA if it is given.",
)
@mode_option("about which poses are planned.  [default: home]")
@require_option("condition<=50, clearance>=0.5", "for rows of --plan")
@seed_option(": of --plan")
@pose_options
@column_options
@output_options(formats=(*FORMATS, "yaml", *DRAWINGS))
def command(o: Options) -> None:
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

    With -o FILE.yaml the result is an instance file with `offset` and `scale` at constraints,
    which
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
    _check_usage(o.spec, o.data, o.log, o.plan, o.mode, o.require, o.targets, o.output)
    from gspcli.calibration import Options as FitOptions
    from gspcli.calibration import calibrate_rows
    from gspcli.calibration.measurements import read_measurements, targets_of

    noise, options = (
        standard_deviations(o.sigmas),
        FitOptions(o.estimate, o.hold, o.robust, o.prior, o.hold_unknown),
    )
    if o.log is not None:
        identified(o.log, o.form_of(None), noise, options, o.output, accept=o.accept)
        return
    assert o.spec is not None
    instance = o.instance
    form = o.form
    places, seen = targets_of(o.targets), None
    if o.data is not None:
        seen = read_measurements(*text_of(o.data), instance, form, places)
    if o.plan is not None:
        wanted = required(o.require)
        _plan(instance, seen, noise, options, o.plan, o.mode, wanted, o.seed, form.frame, o.output)
        return
    assert seen is not None
    with working("fitting"):
        result = calibrate_rows(instance, seen, noise, options)
    _show(result, o.output, accept=o.accept)


def _check_usage(
    spec: str | None,
    data: str | None,
    log: str | None,
    plan: int | None,
    mode: Mode | None,
    require: str | None,
    targets: tuple[str, ...],
    output: Output,
) -> None:
    """Raise if arguments and options do not go together."""
    message = ""
    if log is not None:
        if spec is not None or plan is not None or targets:
            message = "--from LOG needs no SPEC and no DATA, and takes no --plan and no --target"
    elif spec is None:
        message = "give SPEC and DATA, or --from LOG without a file to start from"
    elif data is None and plan is None:
        message = "give DATA, or --plan N for which poses to measure"
    if not message and mode is not None and plan is None:
        message = "--mode says about which pose to plan: give it with --plan"
    elif not message and require is not None and plan is None:
        message = "--require is for the poses of --plan only"
    elif not message and plan is not None and output.format in ("yaml", *DRAWINGS):
        message = f"a plan cannot be written as {output.format}: use one of {', '.join(FORMATS)}"
    if message:
        raise click.UsageError(message)


def _show(result: Calibration, output: Output, *, accept: bool) -> None:
    """Write the new numbers, the residuals or the table of both."""
    refused = bool(result.doubts) and not accept
    if output.format == "yaml":
        from gspcli.calibration.calibrating import calibrated_text

        if not refused:
            write(output, calibrated_text(result))
    elif output.format in DRAWINGS:
        from gspcli.pictures.charts import residual_chart

        write(output, residual_chart(result, output.format))
    else:
        document = calibration_document(result) if output.format == "json" else None
        emit(output, calibration_table(result), document=document)
    if refused:
        what = [f"the data do not fit the machine: {result.doubts[0]}"]
        what += [result.cause] if result.cause else []
        robust = "" if result.options.robust else ", or try --robust"
        what.append(
            f"look for wrong rows and columns (-o FILE.svg shows residuals){robust}; --accept "
            "takes the result unchanged"
        )
        raise CheckFailed("\n".join(what))


def _plan(
    instance: Instance,
    seen: Measurements | None,
    noise: dict[str, float],
    options: FitOptions,
    count: int,
    mode: Mode | None,
    requirements: list[Requirement],
    seed: int,
    frame: PoseFrame,
    output: Output,
) -> None:
    """Write which poses to measure."""
    from gspcli.calibration.planning import planned
    from gspcli.cli.commands.workspace import home_pose
    from gspcli.motion import PoseFormat

    home = home_pose(
        instance,
        PoseFormat(),
        mode=mode,
        pose=None,
        orientation=None,
        position=None,
        needed=True,
    )
    with working("choosing poses"):
        found = planned(
            instance,
            count,
            home.R,
            home.T,
            seen=seen,
            sigma=noise,
            options=options,
            seed=seed,
            allowed=partial(_allowed, instance, requirements) if requirements else None,
        )
    document = plan_document(found) if output.format == "json" else None
    emit(output, plan_table(found, frame), document=document)


def _allowed(
    instance: Instance, requirements: list[Requirement], R: Array, T: Array
) -> NDArray[np.bool_]:
    """Return which poses keep what is required."""
    from gspcli.motion.files.requirements import keeping
    from gspcli.motion.poses.inverse_kinematics import values_at

    values = values_at(instance, R, T)
    return keeping(requirements, measured_quantities(instance, requirements, values, R, T))


_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def calibration_table(result: Calibration, remarks: Sequence[str] | None = None) -> Result:
    """Return the numbers found beside those stated; of a log, with `remarks`, none are stated."""
    rows = [
        {
            "number": name,
            "stated": before,
            "found": after,
            "sigma": float(f"{sigma:.3g}"),
            "change/sigma": float(f"{(after - before) / sigma:.4g}") if sigma > 0 else None,
        }
        for name, before, after, sigma in zip(
            result.names,
            result.before.tolist(),
            result.after.tolist(),
            result.sigma.tolist(),
            strict=True,
        )
    ]
    columns = [
        FIELDS["number"],
        *(Field(key, align="right", essential=True, aligned=True) for key in ("stated", "found")),
        *FIELDS.of("sigma change/sigma"),
    ]
    if remarks is not None:
        columns = [one for one in columns if one.key not in ("stated", "change/sigma")]
        rows = [{one.key: row[one.key] for one in columns} for row in rows]
    units = result.stated.units
    return Result(
        columns,
        rows,
        title=result.stated.title,
        summary=[*(remarks or ()), *_summary(result)],
        notes=[
            f"lengths in {units.length}, angles in {units.angle.value}; scales and directions plain"
        ],
    )


def _summary(result: Calibration) -> list[str]:
    """Return the result in sentences."""
    import numpy as np

    from gspcli.calibration.judging import quantile

    chi, freedom = result.chi_squared, result.freedom
    lines = [f"the data do not fit: {doubt}" for doubt in result.doubts]
    if result.cause:
        lines.append(result.cause)
    lines.append(
        f"{counted(len(result.seen), 'row')}, {counted(len(result.names), 'number')} found"
    )
    if freedom <= 0:
        lines.append("as many numbers are found as were measured: their errors are not known")
    elif result.scatter == 1.0:
        lines.append(
            f"chi-squared {chi:.4g} of {freedom} degrees of freedom, "
            f"between {quantile(freedom, -1.96):.4g} and {quantile(freedom, 1.96):.4g} in 95 %"
        )
    else:
        units, noise = result.stated.units, f"{result.noise.value * result.scatter:.2g}"
        noise += f" {units.length}"
        if result.seen.rods.all():
            # Nothing is read but drives.
            noise = _noise_of_drives(result)
        lines.append(
            f"the noise is not stated: {noise} by the scatter ({freedom} degrees of freedom)"
        )
    if result.outliers.any():
        rows = [result.seen.lines[k] for k in np.flatnonzero(result.outliers.any(axis=1))]
        lines.append(
            f"{counted(int(result.outliers.sum()), 'number')} left out, more than 5 sigma away: in "
            f"{'row' if len(rows) == 1 else 'rows'} {listed(rows, 'and')}"
        )
    if result.unknowns.missing:
        what = counted(result.unknowns.missing, "direction")
        lines.append(
            f"{what} not determined by the data, kept as stated: "
            f"{'; '.join(result.unknowns.sentences)}"
        )
    if result.repeated:
        lines.append(
            f"{counted(result.repeated, 'row')} with the same numbers as another: each counts as "
            "measured again, so that deviations are too small if they are copies"
        )
    if result.home:
        lines.append(result.home)
    if result.unknowns.frames:
        lines.append("the frames of base and platform are fitted to those stated")
    worst = result.worst
    if worst is not None:
        row, left, moved = worst
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
    parts = []
    if "crank" in sorts:
        parts.append(f"{crank:.2g} {units.angle.value} of cranks")
    if "slide" in sorts:
        parts.append(f"{result.noise.slide * result.scatter:.2g} {units.length} of slides")
    return listed(parts, "and")


def calibration_document(result: Calibration) -> dict[str, Any]:
    """Return the JSON document of a calibration."""
    return {"schema": "gsp.calibrate/1", **result.to_json()}


def plan_table(plan: Plan, frame: PoseFrame) -> Result:
    """Return poses to measure, as expressed in a frame, with what the machine reads there."""
    from gspcli.geometry.arrangement import Arrangement

    columns = FIELDS.of("t")
    columns += pose_columns(_POSE, Arrangement.of(plan.instance).length)
    columns += [
        Field(str(k), f"{k} {row.kind.name}", align="right", aligned=True, minor=1)
        for k, row in enumerate(plan.instance.constraints, 1)
        if k - 1 not in plan.driven
    ]
    columns += [Field(name, align="right", aligned=True, minor=1) for name in plan.drive_names]
    read = [column.key for column in columns[1 + len(_POSE) :]]
    return Result(
        columns,
        [
            {
                "t": k,
                **dict(zip(_POSE, pose, strict=True)),
                **{str(j): value for j, value in enumerate(readings, 1)},
                **dict(zip(plan.drive_names, angles, strict=True)),
            }
            for k, (pose, readings, angles) in enumerate(
                zip(
                    plan.expressed(frame).tolist(),
                    plan.readings.tolist(),
                    plan.drives.tolist(),
                    strict=True,
                ),
                1,
            )
        ],
        title=plan.instance.title,
        summary=plan.sentences,
        notes=[
            f"{listed(read, 'and')} are readings with the geometry as stated: replace them by what "
            "is read",
            *frame_note(frame),
        ],
    )


def plan_document(plan: Plan) -> dict[str, Any]:
    """Return the JSON document of a plan."""
    return {"schema": "gsp.calibrate/1", **plan.to_json()}


def identified(
    path: str,
    form: PoseFormat,
    noise: dict[str, float],
    options: FitOptions,
    output: Output,
    *,
    accept: bool,
) -> None:
    """Find a hexapod from a log, and write its numbers, its instance file or the residuals."""
    import numpy as np

    from gspcli.calibration.identifying import identify_log, read_log

    log = read_log(*text_of(path), form.ignore, form.columns)
    with working("finding the machine"):
        found = identify_log(log, form.euler, np.array(form.pivot), noise, options)
    result, said = found.calibration, found.sentences
    refused = bool(found.doubts) and not accept
    if output.format == "yaml":
        from gspcli.calibration.calibrating import calibrated_text

        if not refused:
            write(output, calibrated_text(result, [f"from {named(path)}", *said]))
    elif output.format in DRAWINGS:
        from gspcli.pictures.charts import residual_chart

        write(output, residual_chart(result, output.format))
    else:
        document = {"schema": "gsp.calibrate/1", **found.to_json()}
        emit(
            output,
            calibration_table(result, said),
            document=document if output.format == "json" else None,
        )
    if output.format in ("yaml", *DRAWINGS):
        for sentence in said:
            click.echo(sentence, err=True)
    if refused:
        raise CheckFailed(
            f"the log does not fit a machine with six legs: {found.doubts[0]}\n"
            "look for wrong rows, or try --robust; --accept takes the result unchanged"
        )
