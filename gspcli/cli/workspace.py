"""`gsp workspace`: what a platform can reach."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

from gspcli.cli.grids import PARAMETERS, span_of
from gspcli.cli.mode_option import Mode, mode_option
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Finite, Whole
from gspcli.cli.output import (
    DRAWINGS,
    FORMATS,
    Output,
    emit,
    output_options,
    write,
)
from gspcli.cli.pose_options import PoseConventions, pose_options
from gspcli.cli.pose_type import GivenPose, pose_value_option
from gspcli.cli.progress_bars import progress
from gspcli.cli.reachable_home import Home, home_pose
from gspcli.cli.streams import say
from gspcli.cli.travel_tables import show_travels
from gspcli.cli.value_options import Changes, value_options
from gspcli.cli.worker_options import jobs_option
from gspcli.cli.workspace_tables import box_rows, box_table, volume_table, workspace_document
from gspcli.errors import GspError, IncompleteError
from gspcli.geometry.drive_numbers import is_driven
from gspcli.wording import shown

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat, Workspace

#: The tolerance without --gap, and where every box is shown.
_TOLERANCE, _COARSE = 0.01, 0.1
_MOST_SHOWN = 2_000_000


@click.command()
@click.argument("spec", metavar="SPEC")
@mode_option("where to begin.  [default: home]")
@pose_value_option("home, instead of a mode of SPEC")
@click.option(
    "--orientation",
    metavar="NUMBERS",
    help="Positions at this orientation: qw,qx,qy,qz, or rx,ry,rz with --euler.",
)
@click.option("--position", metavar="X,Y,Z", help="Orientations at this position.")
@click.option("--over", metavar="NAMES", help="Let some of x,y,z,rx,ry,rz vary, the others stay.")
@click.option(
    "--within",
    "intervals",
    metavar="NAME=LOW:HIGH",
    multiple=True,
    help="Keep NAME in this interval: only poses there are considered; may be repeated.",
)
@click.option(
    "--shift",
    "held",
    metavar="NAME=VALUE",
    multiple=True,
    help="Travel with NAME moved by VALUE from home, or by LOW:HIGH:COUNT; may be repeated.",
)
@click.option(
    "--connected/--all-parts",
    default=None,
    help="Count only poses that can be reached from home without a singular pose, or all poses.  "
    "[default: connected "
    "if SPEC states home]",
)
@click.option(
    "--leg-gap",
    type=Finite(),
    metavar="D",
    help="Legs must be D apart at every pose, proved; SPEC states their diameters.",
)
@click.option(
    "--gap",
    type=Finite(0, 1, min_open=True, max_open=True),
    metavar="R",
    help=f"The largest relative difference of the bounds of the volume.  [default: {_TOLERANCE}, "
    f"for boxes and pictures of three or more parameters {_COARSE}]",
)
@click.option(
    "--most-boxes",
    type=Whole(1),
    default=100_000_000,
    show_default=True,
    metavar="N",
    help="Judge at most about this many boxes.",
)
@click.option("--boxes", "listed", is_flag=True, help="Write the boxes instead of the volume.")
@value_options
@pose_options
@jobs_option
@output_options(formats=(*FORMATS, *DRAWINGS))
def command(
    spec: str,
    changes: Changes,
    mode: Mode | None,
    pose: GivenPose | None,
    orientation: str | None,
    position: str | None,
    over: str | None,
    intervals: tuple[str, ...],
    held: tuple[str, ...],
    connected: bool | None,
    leg_gap: float | None,
    gap: float | None,
    most_boxes: int,
    listed: bool,
    conventions: PoseConventions,
    jobs: int,
    output: Output,
) -> None:
    """Show what a platform can reach: travel of each axis, positions, orientations.

    A pose can be reached if each value is in its range, and each leg in the cones that SPEC
    states. With --leg-gap no two legs may be nearer than that, nor a leg and a body.

    Without --over, --orientation or --position the travel of each axis is shown: how far it
    goes down and up from home while the other axes stay, and which limits stop it. All digits
    are proved. x, y, z are the position of the pivot; rx, ry, rz are turns about axes through
    it that are parallel to those of the base.

    Three options give volumes. --orientation gives the volume of the positions x, y, z at one
    orientation. --position gives the share of all rotations that can be reached at one position;
    rx, ry, rz vary from home, in the order of --euler or ZYX. --over gives the volume over any of
    these six. A volume lies between two proved bounds: every pose in the boxes of the lower bound
    can be reached, and no pose outside the boxes of the upper bound can. CSV with --boxes lists the
    boxes with the pose in the middle of each, for `gsp view --track`. A picture shows them over two
    parameters, or in slices.

    Home is the pose of --pose or --mode; by default it is the home mode of SPEC, which `gsp
    solve` marks. If SPEC states a home, only poses that are connected with it are counted. If
    not, mirror images are counted, too, and the other modes in the set are named. The exit code
    is 4 if the bounds differ by more than --gap.

    \b
    Examples:
      gsp workspace @workspace-study
      gsp workspace platform.yaml --shift z=-20:20:5 --format csv
      gsp workspace platform.yaml --orientation 1,0,0,0 --all-parts
      gsp workspace platform.yaml --position 0,0,80 --gap 0.05
      gsp workspace platform.yaml --over x,z -o section.svg
      gsp workspace thick.yaml --over x,z --leg-gap 2
    """
    _one_home(mode, pose)
    free = _free(over, orientation, position)
    _check(free, intervals, held, listed, output)
    instance = load_instance(spec, changes)
    form = conventions.form(instance)
    only = instance.home is not None if connected is None else connected
    home = home_pose(
        instance, form, mode=mode, pose=pose, orientation=orientation, position=position,
        needed=is_driven(instance) or free is None or only or orientation is None
        or set(free) != set("xyz"),
    )  # fmt: skip
    sequence = form.euler or "ZYX"
    moving = _moving(instance, conventions, form)
    knees = _knees(instance, moving, home)
    if free is None:
        show_travels(moving, home, sequence, held, output, connected=only, knees=knees, gap=leg_gap)
        return
    only = only and (connected is not None or _keeps_limits(moving, home, knees, leg_gap))
    wanted = gap or _default_gap(free, listed, output)
    from gspcli.motion.workspace.box_division import workspace

    with _interruptible() as interrupted:
        found = workspace(
            moving, home.R, home.T, free=free, pivot=home.pivot, sequence=sequence,
            within=dict(map(_interval, intervals)), connected=only, knees=knees, gap=leg_gap,
            tolerance=wanted, most_boxes=most_boxes, jobs=jobs, progress=progress, stop=interrupted,
        )  # fmt: skip
    _show(found, home, instance, listed, output)
    if interrupted():
        raise KeyboardInterrupt
    _refuse_wide_bounds(found, wanted)


def _moving(instance: Instance, conventions: PoseConventions, form: PoseFormat) -> Instance:
    """Return the platform in the frames in which its poses are expressed."""
    if form.frame.is_identity:
        return instance
    from gspcli.geometry.expressed_instances import expressed_instance

    return expressed_instance(
        instance, pivot=form.pivot, relative=conventions.relative_to is not None
    )


def _default_gap(free: tuple[str, ...], listed: bool, output: Output) -> float:
    coarse = (listed or output.format in DRAWINGS) and len(free) >= 3
    return _COARSE if coarse else _TOLERANCE


def _knees(instance: Instance, moving: Instance, home: Home) -> ArrayLike | None:
    """Return the knees of cranks and slides: of the stated home, or of the one asked for."""
    if not is_driven(instance):
        return None
    from gspcli.motion.workspace.driven_boxes import knees_of

    if instance.home is not None:
        return knees_of(instance)
    return knees_of(moving, home.R, home.T)


def _one_home(mode: object, pose: object) -> None:
    if mode is not None and pose is not None:
        message = "give either --mode or --pose"
        raise click.UsageError(message)


def _keeps_limits(
    instance: Instance, home: Home, knees: ArrayLike | None, gap: float | None
) -> bool:
    """Return whether home keeps the limits; if not, print which it leaves."""
    from gspcli.motion.workspace.travels import too_near, violations

    left = violations(instance, home.R, home.T, knees)
    left += [] if gap is None else too_near(instance, home.R, home.T, gap)
    if left:
        say(f"home, moved as asked, leaves its limits ({left[0]}): all parts are counted")
    return not left


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Note Ctrl-C instead of stopping at once, so that the result so far is shown."""
    seen = []
    try:
        before = signal.signal(signal.SIGINT, lambda *_: seen.append(True))
    except ValueError:  # not the main thread
        yield lambda: False
        return
    try:
        yield lambda: bool(seen)
    finally:
        signal.signal(signal.SIGINT, before)


def _free(
    over: str | None, orientation: str | None, position: str | None
) -> tuple[str, ...] | None:
    """Return which parameters vary; None for the travels."""
    if over is not None:
        names = tuple(name.strip() for name in over.split(","))
        if len(set(names)) < len(names) or not set(names) <= set(PARAMETERS):
            message = (
                f"--over: found {shown(over)}, expected one or more of {', '.join(PARAMETERS)}"
            )
            raise GspError(message)
        return names
    if orientation is not None and position is not None:
        message = "with both --orientation and --position give --over, too"
        raise click.UsageError(message)
    if orientation is not None:
        return ("x", "y", "z")
    return ("rx", "ry", "rz") if position is not None else None


def _check(
    free: tuple[str, ...] | None,
    intervals: tuple[str, ...],
    held: tuple[str, ...],
    listed: bool,
    output: Output,
) -> None:
    """Raise for options that cannot be combined."""
    message = ""
    if free is None and (intervals or listed or output.format in DRAWINGS):
        message = "boxes and pictures need --orientation, --position or --over"
    elif free is not None and held:
        message = "--shift is for the travel of axes: leave out --over and the like, or use --pose"
    elif free is not None and len(free) not in (2, 3) and output.format in DRAWINGS:
        message = "a picture needs two or three parameters"
    if message:
        raise click.UsageError(message)


def _refuse_wide_bounds(found: Workspace, wanted: float) -> None:
    if found.gap > wanted:
        message = (
            f"the bounds of the volume differ by {found.gap:.3g}, relatively, after "
            f"{found.judged} boxes: more than --gap {wanted:g}"
        )
        raise IncompleteError(message)


def _interval(text: str) -> tuple[str, tuple[float, float]]:
    name, low, high, count = span_of("within", text)
    if count is not None:
        message = f"--within: found {shown(text)}, expected NAME=LOW:HIGH, such as z=60:140"
        raise GspError(message)
    return name, (low, high)


def _show(found: Workspace, home: Home, instance: Instance, listed: bool, output: Output) -> None:
    if output.format in DRAWINGS:
        from gspcli.pictures.slices import workspace_slices

        write(output, workspace_slices(found, output.format))
        return
    count = len(found.inner_keys) + len(found.open_keys)
    if listed and count > _MOST_SHOWN:
        message = f"found {count} boxes, expected at most {_MOST_SHOWN}: try a larger --gap"
        raise GspError(message)
    boxes = box_rows(found) if listed else []
    document = None
    if output.format == "json":
        document = workspace_document(found, home, instance, boxes if listed else None)
    table = box_table(found, boxes) if listed else volume_table(found, home, instance)
    emit(output, table, document=document)
