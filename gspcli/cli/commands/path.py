"""`gsp path`: from one pose to another, proved on the whole way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gspcli.cli import options
from gspcli.cli.pose_options import GivenPose, frame_note, pose_options
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result, pose_columns
from gspcli.cli.streams import working
from gspcli.defaults import PATH_SECONDS
from gspcli.errors import CheckFailed, IncompleteError
from gspcli.wording import counted, listed, shown

if TYPE_CHECKING:
    from typing import Any

    from gspcli.geometry.frames import PoseFrame
    from gspcli.motion.paths.planned_paths import PlannedPath, Timing
    from gspcli.motion.paths.planner import ModeGroups

FIELDS = Fields("path")


class _EndType(click.ParamType):  # type: ignore[type-arg]
    """The number of a mode, ``home``, or a POSE."""

    name = "mode or pose"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return a number, ``home``, or a `GivenPose`."""
        del ctx
        if not isinstance(value, str) or value == options.HOME:
            return value
        if value.isascii() and value.isdigit():
            return int(value)
        return GivenPose(value, max(param.opts, key=len) if param else "")


class _LimitType(click.ParamType):  # type: ignore[type-arg]
    """A number above zero of the drives, or NAME=NUMBER of drives, platform and turn."""

    name = "limit"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the numbers by name."""
        if not isinstance(value, str):
            return value
        names, found = ("drives", "platform", "turn"), {}
        for part in value.split(","):
            name, equals, number = part.rpartition("=")
            name = name.strip() if equals else names[0]
            if name not in names:
                self.fail(f"{shown(name)} is not one of drives, platform, turn.", param, ctx)
            if name in found:
                self.fail(f"{name} stands twice.", param, ctx)
            found[name] = options.Positive().convert(number.strip(), param, ctx)
        if "drives" not in found and len(found) < 2:
            self.fail("give drives, or both platform and turn.", param, ctx)
        return found


@click.command(cls=options.Command)
@options.exclusive("--all", "--from")
@options.exclusive("--all", "--to")
@options.exclusive("--all", "--speed")
@options.needs("--speed", "--acceleration")
@options.needs("--acceleration", "--speed")
@click.argument("spec", metavar="SPEC")
@options.option(
    "--from K|home|POSE",
    "Where the path begins: a mode by its number of `gsp solve`, home, or a pose "
    "(x,y,z,qw,qx,qy,qz, or x,y,z,rx,ry,rz with --euler, or @FILE).",
    name="start",
    type=_EndType(),
)
@options.option("--to K|home|POSE", "Where the path ends, likewise.", name="goal", type=_EndType())
@options.option(
    "--all",
    "Instead of one path show which modes are joined by paths, and which are proved apart.",
    name="everything",
)
@options.option(
    "--along",
    "What changes linearly between corners: the values, or x, y, z and the angles.  [default: what "
    "is proved first]",
    type=click.Choice(["values", "poses"]),
)
@options.option(
    "--clear D",
    "Every pose must have this clearance, proved, as gsp clearance measures it.",
    type=options.Finite(0.0),
    default=0.0,
    show_default=False,
)
@options.option(
    "--leg-gap D",
    "Legs must be D apart at every pose, proved; SPEC states their diameters.",
    name="gap",
    type=options.Finite(),
)
@options.option(
    "--time SECONDS",
    "Stop after this time. A path that is found does not depend on it.",
    name="seconds",
    type=options.Positive(),
    default=PATH_SECONDS,
)
@options.option(
    "--speed V",
    "Give the rows times in seconds, at which no drive is faster than V, in the unit of its value "
    "a second: proved, between rows too. Or drives=V,platform=V,turn=V.",
    type=_LimitType(),
)
@options.option(
    "--acceleration A",
    "With --speed: no acceleration is above A, in units a second squared, proved likewise.",
    type=_LimitType(),
)
@options.seed_option("")
@options.value_options
@pose_options
@options.output_options()
def command(o: options.Options) -> None:
    """Plan a path from one pose to another that is proved safe on the whole way.

    Two facts are proved for every pose of the path, also between its rows: it is not singular, and
    it keeps the ranges and cones that SPEC states. The path has straight parts: on each the six
    values change linearly, or position and angles do. CSV has a row for each step, with values and
    pose; `gsp track` takes the file, and `gsp view --track` plays it. In a machine with cranks or
    slides the drives change linearly, and keep their ranges and working modes.

    First both straight ways are tried. If none is proved, a map of random values or poses is made,
    and the path found on it is made shorter. The same seed gives the same path.

    The exit code is 1 if it is proved that there is no path. There are four reasons. An end is
    outside the limits. Det J, or a factor of it, has different signs at both ends, and a regular
    path keeps each sign. The mode fills its whole box of ranges. Legs are nearer at an end than
    --leg-gap. The exit code is 4 if no path was found in the time given.

    With --speed and --acceleration t is in seconds. One number limits each drive: in mm/s and
    mm/s^2 for lengths in mm, in deg/s and deg/s^2 for angles in degrees.
    `drives=50,platform=100,turn=30` limits the pivot of the platform and its turn, too, on ways of
    poses. The platform begins and ends at rest and stops at corners.

    With --all the modes of SPEC are grouped: those of one group are joined by proved paths. The
    exit code is 4 if two groups are not proved to be apart.

    \b
    Examples:
      gsp path @workspace-study --from home --to 3 -o path.csv
      gsp path @rubin-m2 --from 2 --to home --speed 0.001 --acceleration 0.01
      gsp path platform.yaml --from 10,0,420,1,0,0,0 --to home --clear 0.02
      gsp path thick.yaml --from home --to 10,0,420,1,0,0,0 --leg-gap 5
      gsp path @rubin-camera --all
    """
    if not o.everything and (o.start is None or o.goal is None):
        raise click.UsageError("give --from and --to, or --all")
    from gspcli.motion.paths.planner import mode_groups, path

    instance = o.instance
    form = o.form
    if o.everything:
        with working("joining modes"):
            groups = mode_groups(instance, along=o.along, time=o.seconds, seed=o.seed)
        emit(o.output, _groups_table(groups))
        if groups.undecided:
            one, other = groups.undecided[0]
            rest = len(groups.undecided) - 1
            more = f" (and of {rest} more pairs)" if rest else ""
            raise IncompleteError(
                f"groups {one} and {other}{more}: no path was found, and it is not proved that "
                "there is none\ntry --time or another --seed"
            )
        return
    first, last = (
        one.read(form) if isinstance(one, GivenPose) else one for one in (o.start, o.goal)
    )
    # The point of straight ways in the platform's frame; None for its centre.
    pivot = form.frame.tool.shifted(form.pivot).T
    with working("planning"):
        found = path(
            instance, first, last, along=o.along, clear=o.clear, gap=o.gap, time=o.seconds,
            seed=o.seed, pivot=None if pivot is None else pivot.tolist(),
            sequence=form.euler or "ZYX",
            speed=o.speed, acceleration=o.acceleration,
        )  # fmt: skip
    if found.verdict == "proved" or o.output.format == "json":
        emit(o.output, _path_table(found, form.frame))
    ends = f"from {found.start} to {found.goal}"
    if found.verdict == "impossible":
        raise CheckFailed(f"{ends} there is no path, proved\n{found.reason}")
    if found.verdict == "not found":
        raise IncompleteError(
            f"{ends} no path was found in the time given\n"
            "it is not proved that there is none: try --time or another --seed"
        )


def _path_table(found: PlannedPath, frame: PoseFrame) -> Result:
    """Return the rows of a path, with what is proved of its parts above them."""
    from gspcli.geometry.arrangement import Arrangement

    length = Arrangement.of(found.instance).length
    turn = 1 / found.instance.units.angle.in_radians
    kinds = [one.kind.name for one in found.instance.constraints]
    columns = FIELDS.of("t")
    for name in found.columns:
        title = f"{name} {kinds[int(name) - 1]}" if name.isdecimal() else name.replace(".", " ")
        size = length if _is_length(found, name) else turn
        columns.append(FIELDS[name].but(title=title, size=size))
    columns += pose_columns(length)
    document = found.to_json(frame)
    columns += FIELDS.of("condition clearance? gap?", document["rows"])
    title, notes = found.instance.title, frame_note(frame)
    return Result(
        columns, document["rows"], title, notes, _summary(found), schema="path", name="rows",
        head=document,
    )  # fmt: skip


def _summary(found: PlannedPath) -> list[str]:
    """Return in words what is proved."""
    if not found.parts:
        return []
    from gspcli.ties import first_largest

    worst = found.parts[int(first_largest([part.condition for part in found.parts]))]
    unit = found.instance.units.length
    length = f"length {found.length:.4g} {unit}"
    if found.straight_length:
        length += f", {found.length / found.straight_length:.2f} times the straight line"
    ways = f"the {found.along} change" if found.along != "poses" else "position and angles change"
    lines = [
        f"from {found.start} to {found.goal}: proved, "
        f"{counted(found.straight, 'straight part')} ({ways} linearly)",
        length,
        f"largest condition number at a row: {worst.condition:.4g}, from row {worst.first + 1} to "
        f"{worst.last + 1}",
    ]
    if found.timing is not None:
        lines.append(_time(found, found.timing))
    clearance = min(part.clearance for part in found.parts)
    if clearance > 0:
        lines.append(f"clearance on the whole way: at least {clearance:.3g}, proved")
    gaps = [part.gap for part in found.parts if part.gap is not None]
    if gaps:
        lines.append(f"gap on the whole way: at least {min(gaps):.4g} {unit}, proved")
    return lines


def _is_length(found: PlannedPath, drive: str) -> bool:
    """Return whether the number of a drive is a length; else it is an angle."""
    if drive.isdecimal():
        return found.instance.constraints[int(drive) - 1].kind.is_distance
    return drive.startswith("slide")


def _time(found: PlannedPath, timing: Timing) -> str:
    """Return the time of a path, and which speeds and accelerations are below which limits."""
    units = found.instance.units
    angle, length = units.angle.value, str(units.length)
    lengths = {length if _is_length(found, name) else angle for name in found.columns}
    limits = []
    for name, subject, unit in (
        ("drives", "each drive", " or ".join(sorted(lengths, key=length.__ne__))),
        ("platform", "the platform", length),
        ("turn", "its turn", angle),
    ):
        numbers = [
            f"{given[name]:.10g} {unit}/{second}"
            for given, second in ((timing.limits.speed, "s"), (timing.limits.acceleration, "s^2"))
            if name in given
        ]
        limits += [f"{subject} at most {listed(numbers, 'and')}"] if numbers else []
    text = f"{timing.seconds:.4g} s: {', '.join(limits)}"
    stops = len(timing.moves.tops) - 1
    return text + (f"; stops at {counted(stops, 'corner')}" if stops else "")


def _groups_table(found: ModeGroups) -> Result:
    """Return which modes belong together."""
    document = found.to_json()
    rows = [{**row, "status": _status(row)} for row in document["modes"]]
    groups = counted(len(found.groups), "group")
    if found.complete:
        text = f"{groups}: modes of one group are joined by proved paths, all others proved apart"
    else:
        pairs = listed([f"{a} and {b}" for a, b in found.undecided], "or")
        text = f"{groups}; groups {pairs} may belong together: no path was found"
    notes = [f"signs are those of {listed(found.names, 'and')}: a regular path keeps them"]
    if any("?" in str(row["signs"]) for row in rows):
        notes.append("?: the sign is not proved")
    columns, title = FIELDS.of("mode signs group others status"), found.instance.title
    return Result(columns, rows, title, notes, [text], schema="path", name="modes", head=document)


def _status(row: dict[str, object]) -> str:
    if row["left"]:
        return "outside the limits"
    if row["alone"]:
        return "alone, proved: it fills its box of ranges"
    return "proved apart from other groups" if row["apart"] else "may join another group"
