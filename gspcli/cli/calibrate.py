"""`gsp calibrate`: from measured values and poses to the true numbers of a platform."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import click

from gspcli.cli.calibration_tables import calibration_document, calibration_table
from gspcli.cli.mode_option import Mode, mode_option
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Positive, Whole, seed_option
from gspcli.cli.output import DRAWINGS, FORMATS, Output, emit, output_options, write
from gspcli.cli.pose_options import (
    ColumnOptions,
    PoseConventions,
    column_options,
    pose_options,
    text_of,
)
from gspcli.cli.progress_bars import working
from gspcli.cli.requirements import measured_quantities, require_option, required
from gspcli.cli.sigma_options import standard_deviations
from gspcli.errors import CheckFailed

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.calibration import Calibration, Options
    from gspcli.calibration.measurements import Measurements
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion.files.requirements import Requirement

    Array = NDArray[np.float64]

#: The most poses of a plan. More poses take hours to choose, and determine the numbers hardly
#: better than as many random poses.
_MOST_PLANNED = 300


@click.command()
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
    "--robust", is_flag=True, help="Give outliers less weight: by their modulus (pseudo-Huber)."
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
def command(
    spec: str | None,
    data: str | None,
    log: str | None,
    sigmas: tuple[str, ...],
    estimate: tuple[str, ...],
    hold: tuple[str, ...],
    targets: tuple[str, ...],
    robust: bool,
    prior: float | None,
    hold_unknown: bool,
    accept: bool,
    plan: int | None,
    mode: Mode | None,
    require: str | None,
    seed: int,
    conventions: PoseConventions,
    columns: ColumnOptions,
    output: Output,
) -> None:
    """Find the true numbers of a platform from measured values and poses.

    The coordinates of all points, lines and planes and the offsets of the values are found by
    least squares, together with the poses, since everything that is measured has errors. The
    table has the stated number, the one found, its standard deviation sigma, and the change
    over sigma.

    SPEC is the platform as stated, DATA a CSV file with a heading, - for standard input. Any
    cell of DATA may be blank. Its columns are:

    \b
      1 ... 6             what the machine reads (distances to planes signed)
      x, y, z, rotation   the pose as `gsp measure` reads it
      P1.x, P1.y, P1.z    the position of point P1, or of a --target
      incl.x, incl.y      angles of the platform's axes x, y above the horizontal
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
    _check_usage(spec, data, log, plan, mode, require, targets, output)
    from gspcli.calibration import Options, calibrate_rows
    from gspcli.calibration.data_files import read_measurements, targets_of

    noise, options = (
        standard_deviations(sigmas),
        Options(estimate, hold, robust, prior, hold_unknown),
    )
    if log is not None:
        from gspcli.cli.identification import identified

        identified(log, conventions.form(None, columns), noise, options, output, accept=accept)
        return
    assert spec is not None
    instance = load_instance(spec)
    form = conventions.form(instance, columns)
    places, seen = targets_of(targets), None
    if data is not None:
        seen = read_measurements(*text_of(data), instance, form, places)
    if plan is not None:
        wanted = required(require)
        _plan(instance, seen, noise, options, plan, mode, wanted, seed, form.frame, output)
        return
    assert seen is not None
    with working("fitting"):
        result = calibrate_rows(instance, seen, noise, options)
    _show(result, output, accept=accept)


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
    """Raise if arguments and options do not go together.

    Raises
    ------
    click.UsageError
        With what to give instead.
    """
    message = ""
    if log is not None:
        if spec is not None or plan is not None or targets:
            message = "--from LOG needs no SPEC and no DATA, and takes no --plan and no --target"
    elif spec is None:
        message = "give SPEC and DATA, or --from LOG without a file to start from"
    elif data is None and plan is None:
        message = "give DATA, or --plan N for which poses to measure"
    elif spec == data == "-":
        message = "SPEC and DATA cannot both be standard input"
    if not message and mode is not None and plan is None:
        message = "--mode says about which pose to plan: give it with --plan"
    elif not message and require is not None and plan is None:
        message = "--require is for the poses of --plan only"
    elif not message and plan is not None and output.format in ("yaml", *DRAWINGS):
        message = f"a plan cannot be written as {output.format}: use one of {', '.join(FORMATS)}"
    if message:
        raise click.UsageError(message)


def _show(result: Calibration, output: Output, *, accept: bool) -> None:
    """Write the new numbers, the residuals or the table of both.

    Raises
    ------
    CheckFailed
        If the data do not fit the machine, unless that is accepted; no instance file is written
        then.
    """
    refused = bool(result.doubts) and not accept
    if output.format == "yaml":
        from gspcli.calibration.instance_files import calibrated_text

        if not refused:
            write(output, calibrated_text(result))
    elif output.format in DRAWINGS:
        from gspcli.pictures.residual_charts import residual_chart

        write(output, residual_chart(result, output.format))
    else:
        document = calibration_document(result) if output.format == "json" else None
        emit(output, calibration_table(result), document=document)
    if refused:
        what = [f"the data do not fit the machine: {result.doubts[0]}"]
        what += [result.cause] if result.cause else []
        what.append(
            "look for wrong rows and columns (-o FILE.svg shows residuals), or try --robust; "
            "--accept takes the result unchanged"
        )
        raise CheckFailed("\n".join(what))


def _plan(
    instance: Instance,
    seen: Measurements | None,
    noise: dict[str, float],
    options: Options,
    count: int,
    mode: Mode | None,
    requirements: list[Requirement],
    seed: int,
    frame: PoseFrame,
    output: Output,
) -> None:
    """Write which poses to measure."""
    from gspcli.calibration.planning import planned
    from gspcli.cli.calibration_tables import plan_document, plan_table
    from gspcli.cli.reachable_home import home_pose
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
