"""`gsp workspace`: what a platform can reach."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gspcli.cli import options, pose_options
from gspcli.cli.pose_options import PARAMETERS
from gspcli.cli.render import emit, write
from gspcli.cli.result import POSE, Fields, Result, vector_text
from gspcli.cli.streams import progress, say
from gspcli.errors import ArgumentError, GspError, IncompleteError
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.machine import Machine
from gspcli.records import dataclass
from gspcli.wording import listed, shown

if TYPE_CHECKING:
    from gspcli.geometry.instance import Array, Instance
    from gspcli.motion import Travel, Workspace

FIELDS = Fields("workspace")

#: The tolerance without --gap, and where every box is shown.
_TOLERANCE, _COARSE = 0.01, 0.1
_MOST_SHOWN = 2_000_000


@click.command(cls=options.Command)
@options.exclusive("--mode", "--pose")
@options.without("--shift", "--over", "--orientation", "--position")
@options.needs("--within", "--over", "--orientation", "--position")
@options.needs("--boxes", "--over", "--orientation", "--position")
@click.argument("spec", metavar="SPEC")
@pose_options.mode_option("where to begin.  [default: home]")
@pose_options.pose_value_option("home, instead of a mode of SPEC")
@options.option(
    "--orientation NUMBERS", "Positions at this orientation: qw,qx,qy,qz, or rx,ry,rz with --euler."
)
@options.option("--position X,Y,Z", "Orientations at this position.")
@options.option("--over NAMES", "Let some of x,y,z,rx,ry,rz vary, the others stay.")
@options.option(
    "--within NAME=LOW:HIGH",
    "Keep NAME in this interval: only poses there are considered; may be repeated.",
    name="intervals",
    multiple=True,
)
@options.option(
    "--shift NAME=VALUE",
    "Travel with NAME moved by VALUE from home, or by LOW:HIGH:COUNT; may be repeated.",
    name="held",
    multiple=True,
)
@options.option(
    "--connected/--all-parts",
    "Count only poses that can be reached from home without a singular pose, or all poses.  "
    "[default: connected if SPEC states home]",
    default=None,
)
@options.option(
    "--leg-gap D",
    "Legs must be D apart at every pose, proved; SPEC states their diameters.",
    type=options.Finite(),
)
@options.option(
    "--gap R",
    f"The largest relative difference of the bounds of the volume.  [default: {_TOLERANCE}, "
    f"for boxes and pictures of three or more parameters {_COARSE}]",
    type=options.Finite(0, 1, min_open=True, max_open=True),
)
@options.option(
    "--most-boxes",
    "Judge at most about this many boxes.",
    type=options.Whole(1),
    default=100_000_000,
)
@options.option("--boxes", "Write the boxes instead of the volume.", name="listed")
@options.value_options
@pose_options.pose_options
@options.jobs_option
@options.output_options(formats=(*options.FORMATS, *options.DRAWINGS))
def command(o: options.Options) -> None:
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
    from gspcli.motion.workspace.travels import too_near, violations
    from gspcli.motion.workspace.workspaces import workspace

    free = _free(o)
    if o.output.format in options.DRAWINGS and len(free or ()) not in (2, 3):
        raise click.UsageError(
            "a picture needs two or three parameters: give --orientation, --position or --over"
        )
    instance = o.instance
    form = o.form
    only = instance.home is not None if o.connected is None else o.connected
    turning = free is None or o.orientation is None or set(free) != set("xyz")
    machine = Machine.of(instance)
    home = _home(o, needed=turning or only or machine.moves)
    moving = instance
    if not form.frame.is_identity:
        from gspcli.geometry.expressed_instances import expressed_instance

        relative = o.relative_to is not None
        moving = expressed_instance(instance, pivot=form.pivot, relative=relative)
    # Those of the stated home count; a machine without one has those at the home asked for.
    machine = Machine.of(moving) if instance.home is None else machine
    working_modes = machine.at_home(home.R, home.T).signs
    asked = {
        "pivot": home.pivot,
        "sequence": form.euler or "ZYX",
        "working_modes": working_modes,
        "gap": o.leg_gap,
    }
    if free is None:
        emit(o.output, _travels(o, moving, home, asked | {"connected": only}))
        return
    if only and o.connected is None:
        left = violations(moving, home.R, home.T, working_modes)
        left += [] if o.leg_gap is None else too_near(moving, home.R, home.T, o.leg_gap)
        only = not left
        if left:
            say(f"home, moved as asked, leaves its limits ({left[0]}): all parts are counted")
    coarse = (o.listed or o.output.format in options.DRAWINGS) and len(free) >= 3
    wanted = o.gap or (_COARSE if coarse else _TOLERANCE)
    given = partial(pose_options.span_of, names=PARAMETERS, example="60:140", several=False)
    spans = [given("within", text) for text in o.intervals]
    within = {name: (low, high) for name, low, high, _ in spans}
    with _interruptible() as interrupted:
        found = workspace(
            moving, home.R, home.T, free=free, within=within,
            connected=only, tolerance=wanted, most_boxes=o.most_boxes, jobs=o.jobs,
            stop=interrupted, progress=partial(progress, lines=True), **asked,
        )  # fmt: skip
    if o.output.format in options.DRAWINGS:
        from gspcli.pictures.charts import workspace_slices

        write(o.output, workspace_slices(found, o.output.format))
    else:
        emit(o.output, _volume(o, found, home))
    if interrupted():
        raise KeyboardInterrupt
    if found.gap > wanted:
        raise IncompleteError(
            f"the bounds of the volume differ by {found.gap:.3g}, relatively, after "
            f"{found.judged} boxes: more than --gap {wanted:g}"
        )


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


def _free(o: options.Options) -> tuple[str, ...] | None:
    """Return which parameters vary; None for the travels."""
    if o.over is not None:
        names = tuple(name.strip() for name in o.over.split(","))
        if len(set(names)) < len(names) or not set(names) <= set(PARAMETERS):
            expected = f"expected one or more of {', '.join(PARAMETERS)}"
            raise GspError(f"--over: found {shown(o.over)}, {expected}")
        return names
    if o.orientation is not None and o.position is not None:
        raise click.UsageError("with both --orientation and --position give --over, too")
    if o.orientation is not None:
        return PARAMETERS[:3]
    return PARAMETERS[3:] if o.position is not None else None


def _own_pose(row: dict[str, Any], frame: PoseFrame) -> dict[str, list[float]]:
    """Return the pose of the platform itself in the middle of a box."""
    position, quaternion = ([row[key] for key in keys] for keys in (POSE[:3], POSE[3:]))
    if not frame.is_identity:
        from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_quaternion

        R, T = frame.to_platform(rotation_from_quaternion(np.array(quaternion)), position)
        position, quaternion = T.tolist(), quaternion_from_rotation(R).tolist()
    return {"T": position, "quaternion": quaternion}


def _modes_inside(found: Workspace, home: _Home, instance: Instance) -> list[int]:
    """Return the numbers of the modes of SPEC that are in the set, if all its parts are counted.

    Of two of them one is the mirror image of the other, for instance.
    """
    if found.connected:
        return []
    try:
        R, T = home.frame.from_platform(*pose_options.real_poses(instance))
    except GspError:
        # Modes without numbers are not named.
        return []
    return [k + 1 for k, judged in enumerate(found.judged_poses(R, T).tolist()) if judged >= 0]


def _volume(o: options.Options, found: Workspace, home: _Home) -> Result:
    """Return the extents over each parameter, and the volume above them; or the boxes."""
    instance, is_json, gap = o.instance, o.output.format == "json", found.boxes.gap
    count, between = len(found.inner_boxes.keys), len(found.open_boxes.keys)
    if o.listed and count + between > _MOST_SHOWN:
        raise GspError(
            f"found {count + between} boxes, expected at most {_MOST_SHOWN}: try a larger --gap"
        )
    inside = _modes_inside(found, home, instance) if is_json or not o.listed else []
    head = {
        **_head(o, instance, home, connected=found.connected),
        "travel": None,
        **found.to_json(),
        "modes_inside": inside,
    }
    low, high = found.volume
    verb = "can be reached without a singular pose" if found.connected else "can be reached"
    notes = [
        f"home: {home.text}",
        f"proved: {count} boxes inside, {between} between, {found.judged} judged; the "
        "set ends between least and lowest and between highest and most",
    ]
    if found.connected:
        notes.append(
            "connected with home; not counted: what lies beyond singular poses, such as a mirror "
            "image (--all-parts)"
        )
    elif len(inside) > 1:
        notes.append(
            f"all parts are counted: modes {listed(map(str, inside), 'and')} are in them, as a "
            "mode and its mirror image (--connected counts one part)"
        )
    notes += pose_options.frame_note(home.frame)
    if gap is not None:
        notes.append(f"legs and bodies are at least {gap:g} {instance.units.length} apart")
    volume = f"between {low:.6g} and {high:.6g} {found.measure} {verb}"
    summary = [f"{volume} ({100 * found.gap:.2g} % apart)"]
    columns = FIELDS.of("name least lowest highest most")
    title, rows = found.instance.title, head["extents"]
    result = Result(
        columns, rows, title, notes, summary, schema="workspace", name="extents", head=head
    )
    if not o.listed:
        return result
    rows = _box_rows(found)
    if is_json:
        head["boxes"] = [
            {
                "status": row["status"],
                **_own_pose(row, home.frame),
                "box": {name: [row[f"{name}_low"], row[f"{name}_high"]] for name in found.free},
            }
            for row in rows
        ]
    ends = [f"{name}_{end}" for name in found.free for end in ("low", "high")]
    boxes = Result(FIELDS.of(" ".join(("status", *POSE, *ends))), rows)
    return replace(result, summary=(), parts=[boxes])


def _box_rows(found: Workspace) -> list[dict[str, Any]]:
    """Return the boxes with the pose in the middle of each, inner ones first."""
    from gspcli.geometry.quaternions import quaternion_from_rotation

    corners = np.concatenate((found.inner, found.open))
    parameters = np.tile(found.boxes.home, (len(corners), 1))
    for k, name in enumerate(found.free):
        parameters[:, PARAMETERS.index(name)] = corners[:, k].mean(axis=1) * found.units[k]
    R, T = found.boxes.poses(parameters)
    poses = np.concatenate((T, quaternion_from_rotation(R)), axis=1).tolist()
    keys = [f"{name}_{end}" for name in found.free for end in ("low", "high")]
    flat = corners.reshape(len(corners), -1).tolist()
    count = len(found.inner)
    return [
        {
            "status": "inside" if k < count else "open",
            **dict(zip(POSE, pose, strict=True)),
            **dict(zip(keys, ends, strict=True)),
        }
        for k, (pose, ends) in enumerate(zip(poses, flat, strict=True))
    ]


_MOST_HELD = 1000


def _offsets(held: tuple[str, ...]) -> list[dict[str, float]]:
    """Return by how much parameters are moved from home, all combinations."""
    from gspcli.motion.files.number_tables import wrong_number

    choices: dict[str, list[float]] = {}
    for text in held:
        name, equals, value = text.replace(" ", "").partition("=")
        if equals and name in PARAMETERS and not wrong_number(value):
            values = [float(value)]
        else:
            name, low, high, count = pose_options.span_of("shift", text, PARAMETERS, "-20:20:5")
            if count > _MOST_HELD:
                raise GspError(f"--shift: found {count} values, expected at most {_MOST_HELD}")
            values = np.linspace(low, high, count).tolist()
        choices.setdefault(name, []).extend(values)
    found = [dict(zip(choices, row, strict=True)) for row in product(*choices.values())]
    if len(found) > _MOST_HELD:
        raise GspError(f"--shift: found {len(found)} combinations, expected at most {_MOST_HELD}")
    return found


#: What a row of travels has beside the axis.
_TRAVEL = ("down", "up", "total", "down_end", "up_end", "down_stops", "up_stops")


def _travels(o: options.Options, instance: Instance, home: _Home, asked: dict[str, Any]) -> Result:
    """Return how far each axis travels from home, a row for each.

    The instance is in the frames of poses; what is asked for are arguments of `travels`.
    """
    offsets, machine, units = _offsets(o.held), Machine.of(instance), instance.units
    rows: list[dict[str, Any]] = []
    for offset in progress(offsets, total=len(offsets), label="travels", lines=True):
        # Rods that share a carriage stay parallel when the platform moves, not when it turns.
        known = PARAMETERS[:3] if machine.shared else PARAMETERS
        axes = [name for name in known if name not in offset]
        found = _travels_of(instance, home, axes, offset, asked)
        rows += ({"held": offset, **row} for row in map(_travel_row, axes, found))
    columns = [
        FIELDS[f"held_{name}"].but(title=f"{name} held", source=f"held.{name}")
        for name in offsets[0]
    ]
    ends = "down_end up_end" if o.output.format == "csv" else ""
    columns += FIELDS.of(f"axis down up total {ends} down_stops up_stops")
    apart = "" if o.leg_gap is None else f", legs are {o.leg_gap:g} {units.length} apart"
    what = f"all limits are kept{apart}"
    what += " and no pose is singular" if asked["connected"] else ""
    notes = [
        f"from home: {home.text}",
        f"x, y, z in {units.length}, rx, ry, rz in {units.angle.value}; proved: up to there {what}",
    ]
    notes += pose_options.frame_note(home.frame)
    if fixed := [str(k) for k, stays in enumerate(machine.fixed, 1) if stays]:
        stay = "s, kept by all" if len(fixed) > 1 else ", which every pose keeps"
        notes.append(f"fixed value{stay}: {listed(fixed, 'and')}")
    if machine.shared:
        notes.append("rods share drives: what the platform reaches when it turns is not computed")
    if any(row["down"] is None for row in rows):
        notes.append("without numbers: the pose from which an axis would travel leaves the limits")
    head = _head(o, instance, home, connected=asked["connected"]) | {"travel": rows, "volume": None}
    return Result(
        columns, rows, instance.title, notes, schema="workspace", name="travel", head=head
    )


def _travels_of(
    instance: Instance,
    home: _Home,
    axes: list[str],
    offset: dict[str, float],
    asked: dict[str, Any],
) -> Sequence[Travel | None]:
    """Return the travel of each axis from home, moved by an offset; None if that is refused."""
    from gspcli.motion.workspace.travels import moved, travels

    turns = {key: asked[key] for key in ("pivot", "sequence")}
    in_radians = instance.units.angle.in_radians
    R, T = moved(home.R, home.T, offset, in_radians=in_radians, **turns)
    try:
        return travels(instance, R, T, axes=axes, **asked)
    except ArgumentError:
        if not offset:
            raise
        return [None] * len(axes)


def _travel_row(axis: str, travel: Travel | None) -> dict[str, Any]:
    if travel is None:
        return {"axis": axis, **dict.fromkeys(_TRAVEL)}
    down, up = (value + 0.0 for value in travel.reached)
    ends = [value if abs(value) < float("inf") else None for value in travel.ends]
    numbers = (down, up, up - down, *ends, *map(_grouped, travel.stops))
    return {"axis": axis, **dict(zip(_TRAVEL, numbers, strict=True))}


def _grouped(names: tuple[str, ...]) -> str:
    """Return limits in words, those of one sort together: range 1 2, range crank B1 B2."""
    found: dict[str, list[str]] = {}
    for name in names:
        sort, _, which = name.partition(" of ")
        if which.startswith(("crank ", "slide ")):
            motor, which = which.split(" ", 1)
            sort = f"{sort} {motor}"
        found.setdefault(sort, []).append(which)
    return ", ".join(" ".join((sort, *which)).strip() for sort, which in found.items())


@dataclass(frozen=True, eq=False)
class _Home:
    """A pose to start from."""

    #: The pose, shapes (3, 3) and (3,), expressed in `frame`.
    R: Array
    T: Array
    #: The point of the platform whose position counts, in its frame.
    pivot: tuple[float, float, float]
    #: The typical length of the instance, next to which rounding errors are zero.
    size: float
    #: The frame in which the pose is expressed; the platform's own is the identity.
    frame: PoseFrame
    #: Its number as a mode of the instance, or None.
    mode: int | None = None
    #: Whether its position is given.
    placed: bool = True

    @property
    def text(self) -> str:
        """The pose in a few words."""
        from gspcli.geometry.quaternions import quaternion_from_rotation

        rotation = vector_text(quaternion_from_rotation(self.R).tolist(), size=1.0)
        if not self.placed:
            return f"quaternion ({rotation})"
        position = vector_text((self.T + self.R @ self.pivot).tolist(), size=self.size)
        name = "" if self.mode is None else f"mode {self.mode}, "
        return f"{name}position ({position}), quaternion ({rotation})"


def _head(
    o: options.Options, instance: Instance, home: _Home, *, connected: bool
) -> dict[str, Any]:
    """Return what every document of `gsp workspace` begins with."""
    R, T = home.frame.to_platform(home.R, home.T)
    return {
        "schema": "gsp.workspace/1",
        **instance.to_json(),
        "home": {"mode": home.mode, "R": R.tolist(), "T": T.tolist()},
        **({} if home.frame.is_identity else {"frames": home.frame.to_json()}),
        "pivot": list(home.pivot),
        "sequence": o.form.euler or "ZYX",
        "connected": connected,
        "leg_gap": o.leg_gap,
    }


def _home(o: options.Options, *, needed: bool) -> _Home:
    """Return the home pose; without a position if none is needed.

    It is expressed in the frame of the options, if there is one: then the pivot is its origin.
    """
    from gspcli.geometry.arrangement import Arrangement
    from gspcli.motion import read_pose

    form, orientation, position, frame = o.form, o.orientation, o.position, IDENTITY
    if not form.frame.is_identity:
        frame = form.pivot_frame
        form = replace(form, pivot=(0.0, 0.0, 0.0), frame=IDENTITY)
    pivot, size = form.pivot, Arrangement.of(o.instance).length
    number, placed = None, True
    if o.pose is not None:
        R, T = o.pose.read(form)
    elif o.mode is None and (not needed or (orientation is not None and position is not None)):
        R, T, placed = np.eye(3), np.zeros(3), needed
    else:
        number, R, T = pose_options.one_mode(o.instance, o.mode)
        R, T = frame.from_platform(R[0], T[0])
    home = _Home(R, T, pivot, size, frame, number, placed)
    at = home.T + home.R @ pivot
    if orientation is not None:
        count = 3 if form.euler else 4
        if len(orientation.split(",")) != count:
            what = "rx,ry,rz" if form.euler else "qw,qx,qy,qz, or rx,ry,rz with --euler"
            raise GspError(f"--orientation: found {shown(orientation)}, expected {what}")
        R = read_pose(f"0,0,0,{orientation}", form, "--orientation").R[0]
        home = replace(home, R=R, T=at - R @ pivot, mode=None)
    if position is not None:
        at = read_pose(f"{position},1,0,0,0", replace(form, euler=None), "--position").T[0]
        home = replace(home, T=at + np.asarray(pivot) - home.R @ pivot, mode=None)
    return home
