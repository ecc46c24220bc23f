"""`gsp track`: follows the assembly modes while the values change."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import click

from gspcli.cli.limit_sentences import limit_sentences, plain_limit
from gspcli.cli.mode_option import Mode, mode_option
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Whole
from gspcli.cli.output import Output, emit, output_options
from gspcli.cli.pose_options import (
    ColumnOptions,
    PoseConventions,
    column_options,
    pose_options,
    text_of,
)
from gspcli.cli.pose_type import GivenPose, near_option
from gspcli.cli.progress_bars import working
from gspcli.cli.real_poses import mode_number
from gspcli.cli.requirements import refuse, require_option, required
from gspcli.cli.streams import say
from gspcli.cli.track_requirements import judged_track, track_entries, track_lines
from gspcli.cli.track_tables import event_sentence, track_table
from gspcli.cli.track_ways import along_poses, along_values
from gspcli.cli.value_options import Changes, value_options
from gspcli.cli.worker_options import jobs_option
from gspcli.errors import IncompleteError
from gspcli.wording import counted

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion import Track, ValueTable
    from gspcli.motion.files.requirements import Requirement
    from gspcli.motion.following.departures import Departure
    from gspcli.motion.following.limit_event import LimitEvent

    Array = NDArray[np.float64]


@click.command()
@click.argument("spec", metavar="SPEC")
@click.argument("values", metavar="VALUES")
@mode_option("only this one is followed.")
@near_option("only this one is followed")
@value_options
@click.option(
    "--steps",
    type=Whole(1),
    default=1,
    show_default=True,
    metavar="N",
    help="Write N rows for each row of VALUES, evenly between it and the next one.",
)
@click.option(
    "--along",
    type=click.Choice(["values", "poses"]),
    default="values",
    show_default=True,
    help="What changes linearly between rows; of a file of poses it can be x, y, z and the angles.",
)
@click.option("--relative", is_flag=True, help="The values in the file are added to those of SPEC.")
@click.option(
    "--all-modes",
    is_flag=True,
    help="All real poses: along a file of poses follow all, not only the mode of these poses.",
)
@click.option(
    "--complete",
    "everything",
    is_flag=True,
    help="Compare with all poses at the last row, and follow modes that begin on the way, too.",
)
@click.option("--allow-loss", is_flag=True, help="Exit with 0 though a mode ends on the way.")
@click.option(
    "--clearance",
    "clear",
    is_flag=True,
    help="Add how far all values may change with proof that nothing is singular (gsp clearance).",
)
@click.option(
    "--pose-clearance",
    "pose_clear",
    is_flag=True,
    help="Add how far the pose may move, for any values, with proof that its screws stay "
    "independent (gsp clearance --of pose).",
)
@click.option(
    "--no-certify", is_flag=True, help="Do not prove what is found: that no branch is changed."
)
@require_option("range, cone, clearance>=0.5, condition<=50")
@pose_options
@column_options
@jobs_option
@output_options()
def command(
    spec: str,
    values: str,
    mode: Mode | None,
    near: GivenPose | None,
    changes: Changes,
    steps: int,
    along: str,
    relative: bool,
    all_modes: bool,
    everything: bool,
    allow_loss: bool,
    clear: bool,
    pose_clear: bool,
    no_certify: bool,
    require: str | None,
    conventions: PoseConventions,
    columns: ColumnOptions,
    jobs: int,
    output: Output,
) -> None:
    """Follow assembly modes while the values change, and prove that none jumps.

    Each row of the output is one mode at one row of VALUES: position and unit quaternion of the
    platform (x_base = R x_platform + T) and the condition number. Between rows it is proved
    that the mode is the only one near, so that it cannot be mistaken for another. Where two
    modes meet and vanish (a fold), t is proved to ten digits or more. Events between rows are
    printed on standard error, and in JSON under events.

    SPEC is an instance file, VALUES a CSV file with a heading: columns 1 to 6, and perhaps t.
    Columns that are left out keep the value of SPEC. VALUES may also be a file of poses as `gsp
    measure` takes it; the values are then measured at the poses. One of the files may be - for
    standard input. The values change linearly between rows; distances to planes (DPH, DHP) are
    signed.

    Other columns move the machine itself. Coordinates of points, lines and planes are base.NAME.x,
    platform.NAME.y, base.NAME.direction.z and base.NAME.normal.x. The column crank.NAME is the
    angle of a crank, slide.NAME the place of a slide, if SPEC states them. They change linearly,
    too: the point of a crank moves on its circle. In a file of poses, cranks and slides are where
    `gsp measure --drives` has them, and the rods keep their lengths. Events tell where they leave
    their ranges, and between which rows a mode passes a dead point.

    All real poses at the first row are followed. Along a file of poses only the mode of these poses
    is followed, unless --all-modes or --complete is given. Modes have the numbers of `gsp solve
    SPEC`. If the first row differs from SPEC, the modes are followed with proof from the values of
    SPEC to the first row. Modes that are not reached in this way are new, and have the next
    numbers.

    Events also tell where values leave their ranges, and legs the cones of their joints (`range`,
    `cone` in SPEC). They are proved for all poses between rows; with --no-certify cones are checked
    at the rows only.

    --require names the worst row of each requirement, and the exit code is 1 unless all rows keep
    all of them. Ranges, cones, condition, clearance, gap and transmission must hold between the
    rows, too, with proof, unless coordinates move other than those of cranks and slides.

    --along poses changes x, y, z and the angles linearly between the rows of a file of poses,
    as a controller with six axes does. The angles are rx, ry, rz in the order of --euler, ZYX
    by default, each the shorter way round. It is proved that no pose on the way is singular, and
    that no crank or slide passes a dead point.

    The exit code is 4 if a mode ends before the last row, unless --allow-loss is given. It is
    also 4 if a mode that is followed along a file of poses is not at the pose of a row.

    \b
    Examples:
      gsp track platform.yaml values.csv -o poses.csv
      gsp track platform.yaml path.csv --euler ZYX --format json
      gsp track platform.yaml values.csv --mode home
      gsp track rotary.yaml angles.csv --steps 10
      gsp track platform.yaml path.csv --require "cone, clearance>=0.5"
      gsp track platform.yaml values.csv --complete --allow-loss
      gsp track platform.yaml values.csv --steps 20 --format csv |
        gsp view platform.yaml --track -
    """
    _check(mode, near, spec, values)
    from gspcli.motion import read_values

    instance = load_instance(spec, changes)
    requirements = required(require)
    form = conventions.form(instance, columns)
    table = read_values(*text_of(values), instance, form, delta=relative)
    if along == "poses":
        _check_poses(table, mode, near, all_modes or everything or no_certify)
        done = along_poses(instance, table, form, conventions, steps)
    else:
        table = table.subdivided(steps)
        start = table.start if near is None else near.read(form)
        if near is None and (mode is not None or all_modes or everything):
            start = None
        done = along_values(
            instance,
            table,
            modes=None if mode is None else [mode_number(instance, mode)],
            near=start,
            everything=everything,
            certify=not no_certify,
            jobs=jobs,
        )
    result, limits, left = done.track, done.limits, done.left
    with working("looking for singularities"):
        more = _clearances(result, requirements, clear=clear, pose_clear=pose_clear)
    rows = result.rows(more, form.frame)
    verdicts, added = judged_track(done, requirements, rows)
    shown = track_table(result, rows, limits, added, track_lines(verdicts, rows, steps), form.frame)
    said = {"limits": [*map(plain_limit, limits)], **track_entries(verdicts, rows, steps)}
    said["departures"] = [one.to_json(form.in_radians) for one in left]
    emit(output, shown, document=result.to_json(rows, form.frame) | said)
    _tell(result, limits, output)
    _refuse_losses(result, left, allowed=allow_loss)
    refuse(verdicts)


def _check_poses(
    table: ValueTable, mode: Mode | None, near: GivenPose | None, others: bool
) -> None:
    """Raise for options that cannot be combined with straight ways of poses."""
    message = ""
    if table.poses is None:
        message = "--along poses is about a file of poses: found values"
    elif mode is not None or near is not None or others:
        message = (
            "--along poses follows the poses of the file: leave out --mode, --near, --all-modes, "
            "--complete and --no-certify"
        )
    if message:
        raise click.UsageError(message)


def _check(mode: Mode | None, near: GivenPose | None, spec: str, values: str) -> None:
    """Raise for arguments that cannot be combined."""
    if mode is not None and near is not None:
        message = "give either --mode or --near"
        raise click.UsageError(message)
    if spec == values == "-":
        message = "SPEC and VALUES cannot both be standard input"
        raise click.UsageError(message)


def _tell(result: Track, limits: list[LimitEvent], output: Output) -> None:
    """Say which modes are new, and list the events between the rows; a document has both, too."""
    if output.format == "json":
        return
    if result.new:
        say(_new_modes(result))
    for line in (*map(event_sentence, result.events), *limit_sentences(result, limits)):
        say(line)


def _clearances(
    result: Track, requirements: list[Requirement], *, clear: bool, pose_clear: bool
) -> dict[str, Array]:
    """Return the clearances that are asked for, by their names in rows, each of shape (m, r)."""
    asked = {one.quantity for one in requirements}
    found = {}
    if clear or "clearance" in asked:
        from gspcli.motion.paths.track_bounds import moves_by_drives
        from gspcli.motion.singularities.clearances import clearances, range_weights
        from gspcli.motion.singularities.drive_clearances import drive_clearances

        if moves_by_drives(result):
            found["clearance"] = _of_machine(result, lambda *pose: drive_clearances(*pose)[0])
        else:
            weighted = partial(clearances, weights=range_weights(result.instance))
            found["clearance"] = _of_poses(result, weighted)
    if pose_clear or "pose-clearance" in asked:
        from gspcli.motion.singularities.pose_clearances import pose_clearances

        found["pose_clearance"] = _of_poses(result, pose_clearances)
    return found


def _refuse_losses(result: Track, left: list[Departure], *, allowed: bool) -> None:
    """Raise if modes are not accounted for, end early, or leave the poses of the file."""
    if result.complete is False:
        message = (
            "the modes followed and the poses at the last row do not account for each other\n"
            "give more rows, or try --jobs 1 with a smaller step"
        )
        raise IncompleteError(message)
    if result.ends and not allowed:
        names = ", ".join(str(event.mode) for event in result.ends)
        many = len(result.ends) > 1
        message = (
            f"mode{'s' if many else ''} {names} end{'' if many else 's'} before the last row\n"
            "use --allow-loss if that is expected"
        )
        raise IncompleteError(message)
    if left:
        raise IncompleteError(_departure_sentences(left, result.instance))


def _departure_sentences(left: list[Departure], instance: Instance) -> str:
    """Return which mode is not at which pose of the file, why that can be, and what to do."""
    first, units = left[0], instance.units
    rows = len({one.row for one in left})
    more = f" (and at {counted(rows - 1, 'more row')})" if rows > 1 else ""
    turn = first.turn / units.angle.in_radians
    return (
        f"row {first.row + 1} (t = {first.t:.6g}): mode {first.mode} is not at the pose of the "
        f"file, but {first.distance:.3g} {units.length} and {turn:.3g} {units.angle.value} away"
        f"{more}\nbetween rows the values change linearly, and another pose has these values, too"
        f"\ngive more poses before row {max(first.row + 1, 2)}"
    )


def _new_modes(result: Track) -> str:
    """Say which modes have no number of `gsp solve SPEC`."""
    names = ", ".join(map(str, result.new))
    if not result.known:
        return f"mode {names}: new, for SPEC has no numbers to carry to the first row"
    many = len(result.new) > 1
    return (
        f"mode{'s' if many else ''} {names}: new, not reached from the {result.known} real poses "
        "of SPEC on the way to the first row"
    )


def _of_machine(result: Track, bound: Callable[[Instance, Array, Array], Array]) -> Array:
    """Return what is bounded at each pose of the whole machine with its drives, shape (m, r)."""
    import numpy as np

    there = ~np.isnan(result.T[..., 0])
    found = np.full(there.shape, np.nan)
    found[there] = bound(result.instance, result.R[there], result.T[there])
    return found


def _of_poses(result: Track, bound: Callable[[Instance, Array, Array], Array]) -> Array:
    """Return what is bounded at each pose, shape (m, r); NaN where a mode is not."""
    import numpy as np

    found = np.full(result.T.shape[:2], np.nan)
    for rows, instance in result.instances():
        there = np.zeros(found.shape, bool)
        there[:, rows] = ~np.isnan(result.T[:, rows, 0])
        found[there] = bound(instance, result.R[there], result.T[there])
    return found
