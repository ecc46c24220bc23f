"""`gsp track`: follows the assembly modes while the values change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import (
    Command,
    Options,
    Whole,
    exclusive,
    jobs_option,
    output_options,
    value_options,
)
from gspcli.cli.pose_options import (
    column_options,
    frame_note,
    mode_number,
    mode_option,
    near_option,
    pose_options,
    text_of,
)
from gspcli.cli.render import Output, emit
from gspcli.cli.requirements import (
    gaps_of,
    judged,
    limits_of,
    measured_quantities,
    refuse,
    require_option,
    required,
)
from gspcli.cli.result import Fields, Result, pose_columns
from gspcli.cli.streams import say, working
from gspcli.errors import GspError, IncompleteError
from gspcli.geometry.limits import joint_cones
from gspcli.records import dataclass
from gspcli.wording import counted, listed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion import Event, PoseFormat, Track, ValueTable
    from gspcli.motion.files.requirements import (
        QuantityParts,
        Requirement,
        RequirementVerdict,
    )
    from gspcli.motion.following.tracks import Departure
    from gspcli.motion.paths.limit_events import LimitEvent
    from gspcli.motion.paths.pose_ways import PoseWays

    Array = NDArray[np.float64]

FIELDS = Fields("track")


@click.command(cls=Command)
@exclusive("--mode", "--near")
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
@require_option("range, cone, clearance>=0.5, condition<=50")
@pose_options
@column_options
@jobs_option
@output_options()
def command(o: Options) -> None:
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

    The column crank.NAME is the angle of a crank, slide.NAME the place of a slide, if SPEC states
    them. They change linearly, too: the point of a crank moves on its circle. In a file of poses,
    cranks and slides are where `gsp measure --drives` has them, and the rods keep their lengths.
    Events tell where they leave their ranges, and between which rows a mode passes a dead point.

    All real poses at the first row are followed. Along a file of poses only the mode of these poses
    is followed, unless --all-modes or --complete is given. Modes have the numbers of `gsp solve
    SPEC`. If the first row differs from SPEC, the modes are followed with proof from the values of
    SPEC to the first row. Modes that are not reached in this way are new, and have the next
    numbers.

    Events also tell where values leave their ranges, and legs the cones of their joints (`range`,
    `cone` in SPEC). They are proved for all poses between rows.

    --require names the worst row of each requirement, and the exit code is 1 unless all rows keep
    all of them. Ranges, cones, condition, clearance, gap and transmission must hold between the
    rows, too, with proof.

    --along poses changes x, y, z and the angles linearly between the rows of a file of poses,
    as a controller with six axes does. The angles are rx, ry, rz in the order of --euler, ZYX
    by default. Of the two triples that each rotation has, and of their whole turns, those are
    taken that are nearest to the row before. It is proved that no pose on the way is singular, and
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
    from gspcli.motion import read_values

    instance = o.instance
    requirements = required(o.require)
    form = o.form
    table = read_values(*text_of(o.values), instance, form, delta=o.relative)
    if o.along == "poses":
        if table.poses is None:
            raise click.UsageError("--along poses is about a file of poses: found values")
        if o.mode is not None or o.near is not None or o.all_modes or o.everything:
            raise click.UsageError(
                "--along poses follows the poses of the file: leave out --mode, --near, "
                "--all-modes and --complete"
            )
        done = along_poses(instance, table, form, o.steps, relative=o.relative_to is not None)
    else:
        table = table.subdivided(o.steps)
        start = table.start if o.near is None else o.near.read(form)
        if o.near is None and (o.mode is not None or o.all_modes or o.everything):
            start = None
        done = along_values(
            instance,
            table,
            modes=None if o.mode is None else [mode_number(instance, o.mode)],
            near=start,
            everything=o.everything,
            jobs=o.jobs,
        )
    result, limits, left = done.track, done.limits, done.left
    with working("looking for singularities"):
        more = _clearances(result, requirements, clear=o.clear, pose_clear=o.pose_clear)
    rows = result.rows(more, form.frame)
    shown = track_table(result, rows, limits, form.frame)
    head: dict[str, Any] = {**shown.head, "limits": [*map(plain_limit, limits)]}
    head |= {"requirements": []} if requirements else {}
    head["departures"] = [one.to_json(form.in_radians) for one in left]
    shown = replace(shown, head=head)
    verdicts: list[RequirementVerdict] = []
    if requirements:
        verdicts, quantities = judged_track(done, requirements, rows)
        numbers = {
            t: k // o.steps + 1 for k, t in enumerate(dict.fromkeys(row["t"] for row in rows))
        }
        places = [{"row": numbers[row["t"]], "t": row["t"], "mode": row["mode"]} for row in rows]
        shown = judged(shown, verdicts, quantities, places, between=True)
    emit(o.output, shown)
    _tell(result, limits, o.output)
    _refuse_losses(result, left, allowed=o.allow_loss)
    refuse(verdicts)


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
        from gspcli.motion.singularities.clearances import (
            clearances,
            drive_clearances,
            range_weights,
        )

        if moves_by_drives(result):
            whole = [(slice(None), result.instance)]
            found["clearance"] = _at_poses(result, lambda *pose: drive_clearances(*pose)[0], whole)
        else:
            weighted = partial(clearances, weights=range_weights(result.instance))
            found["clearance"] = _at_poses(result, weighted, result.instances())
    if pose_clear or "pose-clearance" in asked:
        from gspcli.motion.singularities.pose_clearances import pose_clearances

        found["pose_clearance"] = _at_poses(result, pose_clearances, result.instances())
    return found


def _refuse_losses(result: Track, left: list[Departure], *, allowed: bool) -> None:
    """Raise if modes are not accounted for, end early, or leave the poses of the file."""
    if result.complete is False:
        raise IncompleteError(
            "the modes followed and the poses at the last row do not account for each other\n"
            "give more rows, or try --jobs 1 with a smaller step"
        )
    if result.ends and not allowed:
        names = ", ".join(str(event.mode) for event in result.ends)
        many = len(result.ends) > 1
        raise IncompleteError(
            f"mode{'s' if many else ''} {names} end{'' if many else 's'} before the last row\n"
            "use --allow-loss if that is expected"
        )
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


def _at_poses(
    result: Track,
    bound: Callable[[Instance, Array, Array], Array],
    parts: Iterable[tuple[slice, Instance]],
) -> Array:
    """Return what is bounded at each pose, shape (m, r); NaN where a mode is not.

    Each part has rows, and the platform there.
    """
    import numpy as np

    found = np.full(result.T.shape[:2], np.nan)
    for rows, instance in parts:
        there = np.zeros(found.shape, bool)
        there[:, rows] = ~np.isnan(result.T[:, rows, 0])
        found[there] = bound(instance, result.R[there], result.T[there])
    return found


def track_table(
    result: Track,
    rows: list[dict[str, Any]],
    limits: list[LimitEvent],
    frame: PoseFrame,
) -> Result:
    """Return the table of the rows, with what is proved of the track below it."""
    from gspcli.geometry.arrangement import Arrangement

    columns = FIELDS.of("t mode")
    columns += pose_columns(Arrangement.of(result.instance).length)
    columns += FIELDS.of("condition clearance? pose_clearance?", rows)
    names = [one.name for one in result.coordinates]
    columns += [FIELDS[name] for name in names]
    document = result.to_json(rows, frame)
    if names:
        places = zip(result.t.tolist(), result.places.tolist(), strict=True)
        at = {t: dict(zip(names, place, strict=True)) for t, place in places}
        rows = [{**row, **at[row["t"]]} for row in rows]
    instance = result.instance
    title = instance.title
    kept = len(result.modes) - len(result.events)
    how = "proved" if result.certified else "not proved"
    note = (
        f"{counted(len(result.modes), 'mode')}, {kept} of them from the first row to the last, "
        f"{how}"
    )
    if result.complete:
        note += "; every real pose at the last row is accounted for"
    notes = [note, *cones_notes(result, limits), *frame_note(frame)]
    return Result(columns, rows, title, notes, schema="track", name="poses", head=document)


def event_sentence(event: Event) -> str:
    """Return an event of a mode between rows, in words."""
    if event.kind == "undecided":
        what = "cannot be followed back before" if event.begins else "cannot be followed beyond"
        t = event.high if event.begins else event.low
        return f"mode {event.mode} {what} t = {t:.10g}: {event.reason} (undecided)"
    partner = "another" if event.partner is None else f"mode {event.partner}"
    if event.begins:
        return f"mode {event.mode} begins with {partner} in a fold at t = {event.low:.12g}, proved"
    return f"mode {event.mode} meets {partner} in a fold at t = {event.low:.12g} and ends, proved"


@dataclass(frozen=True, eq=False)
class FollowedTrack:
    """A track, with its limits and events.

    Attributes
    ----------
    track
        What was followed.
    limits
        Where ranges and cones are left.
    left
        Where it is not at the poses of the file.
    ways
        The straight ways in position and angles from row to row; None for ways of values.
    frame
        The frame of the poses of these ways; None for the platform's own.
    """

    track: Track
    limits: list[LimitEvent]
    left: list[Departure]
    ways: PoseWays | None = None
    frame: PoseFrame | None = None


def along_values(
    instance: Instance,
    table: ValueTable,
    *,
    modes: Sequence[int] | None,
    near: tuple[Array, Array] | None,
    everything: bool,
    jobs: int,
) -> FollowedTrack:
    """Follow modes while the values change linearly; arguments as for `gspcli.track`."""
    from gspcli.motion import departures, track
    from gspcli.motion.paths.limit_events import limit_events

    with working("following"):
        result = track(
            instance,
            table.values,
            coordinates=table.coordinates,
            t=table.t,
            modes=modes,
            near=near,
            everything=everything,
            jobs=jobs,
        )
    if not everything and not len(result.modes):
        raise GspError(
            "there is no real pose at the first row\n"
            "begin with other values, or use --complete for modes that begin on the way"
        )
    with working("looking at limits"):
        limits = limit_events(result)
    left = [] if table.poses is None else departures(result, *table.poses)
    return FollowedTrack(result, limits, left)


def along_poses(
    instance: Instance,
    table: ValueTable,
    form: PoseFormat,
    steps: int,
    *,
    relative: bool,
) -> FollowedTrack:
    """Prove the straight ways in position and angles between the poses of a file."""
    from gspcli.geometry.expressed_instances import expressed_instance
    from gspcli.geometry.readings import without_corrections
    from gspcli.motion import track
    from gspcli.motion.paths.pose_tracks import pose_track

    assert table.poses is not None
    with working("proving"):
        # Its only row determines the mode at which the file begins.
        at = {name: column[:1] for name, column in table.coordinates.items()}
        first = track(instance, table.values[:1], coordinates=at, near=table.start)
        given, frame = without_corrections(instance), form.pivot_frame
        expressed = given
        if not frame.is_identity:
            expressed = expressed_instance(given, pivot=form.pivot, relative=relative)
        found = pose_track(
            given,
            expressed,
            frame,
            table.t,
            *table.poses,
            sequence=form.euler or "ZYX",
            mode=int(first.modes[0]),
            steps=steps,
        )
    # Readings are those of the file.
    result = replace(found.track, instance=instance)
    return FollowedTrack(result, list(found.limits), [], found.ways, frame)


#: Quantities that have their columns in every track, or by options.
_KNOWN = ("condition", "clearance", "pose_clearance")


def judged_track(
    done: FollowedTrack,
    requirements: Sequence[Requirement],
    rows: list[dict[str, Any]],
) -> tuple[list[RequirementVerdict], dict[str, Array | QuantityParts]]:
    """Return whether a track keeps what is required, and quantities that its rows do not have."""
    import numpy as np

    from gspcli.motion.files.requirements import judge

    result = done.track

    known = {
        key.replace("_", "-"): np.array([row[key] for row in rows])
        for key in _KNOWN
        if all(key in row for row in rows)
    }
    quantities: dict[str, Array | QuantityParts] = dict(known)
    for one in requirements:
        if one.quantity not in quantities:
            quantities[one.quantity] = _at_all_rows(result, one)
    verdicts = [_between(one, done) for one in judge(requirements, quantities)]
    more = {name: numbers for name, numbers in quantities.items() if name not in known}
    return verdicts, more


def _at_all_rows(result: Track, requirement: Requirement) -> Array | QuantityParts:
    """Return a quantity of each pose, in the order of the rows; the geometry may move."""
    import numpy as np

    from gspcli.geometry.machine import Machine, is_driven
    from gspcli.motion.files.requirements import QuantityParts
    from gspcli.motion.paths.limit_events import drive_rows

    name, instance = requirement.quantity, result.instance
    if is_driven(instance) and name in ("range", "transmission", "gap"):
        rows, modes = np.nonzero(~np.isnan(result.T[..., 0].T))
        R, T = (array[modes, rows] for array in (result.R, result.T))
        machine = Machine.of(instance)
        q = drive_rows(result, machine)[rows]
        if name == "gap":
            return gaps_of(instance, R, T, q)
        return limits_of(instance, name, result.values[rows], R, T, (machine, q))
    found: list[Array | QuantityParts] = []
    for part, moved in result.instances():
        # What is followed has one side of each plane; ranges are those of the sides asked for.
        platform = instance if name == "range" else moved
        rows, modes = np.nonzero(~np.isnan(result.T[:, part, 0].T))
        values = result.values[part][rows]
        R, T = (array[:, part][modes, rows] for array in (result.R, result.T))
        found.append(measured_quantities(platform, [requirement], values, R, T)[name])
    first = found[0]
    if isinstance(first, QuantityParts):
        every = [part.values for part in found if isinstance(part, QuantityParts)]
        return QuantityParts(np.concatenate(every), first.names)
    return np.concatenate([part for part in found if not isinstance(part, QuantityParts)])


def _between(verdict: RequirementVerdict, done: FollowedTrack) -> RequirementVerdict:
    """Return a verdict that also holds between the rows, where that can be proved."""
    from gspcli.motion.paths.limit_events import cones_proved
    from gspcli.motion.paths.track_bounds import BOUNDED, can_be_bounded

    quantity = verdict.requirement.quantity
    proved = can_be_bounded(done.track, quantity)
    if quantity in BOUNDED:
        return _bounded(verdict, done) if proved and verdict.met else verdict
    if quantity not in ("range", "cone"):
        return verdict
    left = [one for one in done.limits if one.kind == quantity]
    # Values and drives change linearly between rows, so they keep a range that both rows keep.
    known = quantity == "range" or cones_proved(done.track) or done.ways is not None
    if not verdict.met or not left:
        return replace(verdict, between=known)
    event = left[0]
    how = "left" if event.proved else "perhaps left"
    what = event.drive or f"constraint {event.constraint + 1}"
    where = f"{what} {how} between rows at t = {event.low:.9g}"
    return replace(verdict, met=False, part=where, between=known)


def _bounded(verdict: RequirementVerdict, done: FollowedTrack) -> RequirementVerdict:
    """Return a verdict on a quantity of `BOUNDED` that also holds between the rows."""
    from gspcli.motion.paths.track_bounds import worst_between

    quantity, wanted = verdict.requirement.quantity, verdict.requirement.limit
    found = worst_between(done.track, quantity, wanted, done.ways, done.frame)
    if found is None:
        return replace(verdict, between=True)
    t = done.track.t[[found.row, found.row + 1]].tolist()
    word = "at most" if quantity == "condition" else "at least"
    bound = f"{word} {found.bound:.4g} is proved"
    if abs(found.bound) == float("inf"):
        bound = "nothing is proved"
    where = f"between t = {t[0]:.6g} and {t[1]:.6g} {bound}"
    return replace(verdict, met=False, part=where, between=True)


def plain_limit(event: LimitEvent) -> dict[str, Any]:
    """Return an event as plain data."""
    drive = {"drive": event.drive} if event.drive else {}
    return {
        "kind": event.kind,
        "leaves": event.leaves,
        "constraint": event.constraint + 1,
        "body": event.body or None,
        "mode": event.mode,
        "t": [event.low, event.high],
        "proved": event.proved,
        **drive,
    }


def cones_notes(result: Track, events: list[LimitEvent]) -> list[str]:
    """Return which modes are proved to keep all cones, where there are any and anything is."""
    from gspcli.motion.paths.limit_events import cones_proved

    if not joint_cones(result.instance) or not cones_proved(result):
        return []
    leaving = {event.mode for event in events if event.kind != "dead point"}
    modes = [mode for mode in result.modes.tolist() if mode not in leaving]
    if not modes:
        return ["no mode keeps all cones from beginning to end"] if leaving else []
    every = len(modes) == len(result.modes) > 1
    names = "all modes keep" if every else _named(modes)
    return [f"{names} all cones from beginning to end, between rows too: proved"]


def _named(modes: list[int]) -> str:
    if len(modes) == 1:
        return f"mode {modes[0]} keeps"
    return f"modes {listed(map(str, modes), 'and')} keep"


def limit_sentences(result: Track, events: list[LimitEvent]) -> list[str]:
    """Return in words where limits are left and kept again."""
    from gspcli.motion.paths.limit_events import cones_proved

    found = []
    certain = cones_proved(result)
    for _, same in groupby(events, lambda event: (event.proved, event.mode, event.low, event.high)):
        together = list(same)
        cones = [one for one in together if one.kind == "cone"]
        if certain and cones and not cones[0].proved:
            found += [_sentence(result, one) for one in together if one.kind != "cone"]
            found.append(_undecided(cones))
        else:
            found += [_sentence(result, event) for event in together]
    return found


def _undecided(events: list[LimitEvent]) -> str:
    """Return that it is not known whether some cones of a mode are left."""
    event = events[0]
    legs = sorted({one.constraint + 1 for one in events})
    which = (
        f"leg {legs[0]} keeps" if len(legs) == 1 else f"legs {listed(map(str, legs), 'and')} keep"
    )
    cone = "its cone" if len(legs) == 1 else "their cones"
    when = f"between t = {event.low:.10g} and {event.high:.10g}"
    return f"mode {event.mode}: whether {which} {cone} {when} is undecided"


def _sentence(result: Track, event: LimitEvent) -> str:
    at_first = event.high == result.t[0]
    what = "is outside" if at_first else "leaves" if event.leaves else "comes back into"
    if event.drive:
        return _of_drive(result, event, what)
    if event.kind == "range":
        row = result.instance.constraints[event.constraint]
        low, high = map(row.reading_of, row.limits or ())
        when = f"at t = {event.low:.10g}"
        if not event.proved and event.low < event.high:
            what = "may leave"
            when = f"between t = {event.low:.10g} and {event.high:.10g}"
        subject = f"the value of constraint {event.constraint + 1} {what} its range"
        return f"{subject} from {low} to {high} {when}"
    when = f"between t = {event.low:.10g} and {event.high:.10g}"
    if event.proved or event.low == event.high:
        when = f"at t = {event.low:.9g}"
    proved = ", proved" if event.proved else ""
    subject = f"mode {event.mode}: leg {event.constraint + 1} {what} its cone"
    return f"{subject} at the {event.body} {when}{proved}"


def _of_drive(result: Track, event: LimitEvent, what: str) -> str:
    """Return what a crank or slide does."""
    if event.kind == "dead point":
        when = f"between t = {event.low:.10g} and {event.high:.10g}"
        subject = f"mode {event.mode}: rod {event.constraint + 1} passes a dead point"
        return f"{subject} of {event.drive} {when}"
    from gspcli.geometry.machine import Machine

    drives = Machine.of(result.instance)
    k = drives.names.index(event.drive)
    low, high = (f"{drives.readings(end)[k]:.10g}" for end in (drives.low, drives.high))
    when = f"at t = {event.low:.10g}"
    if not event.proved and event.low < event.high:
        what = "may leave"
        when = f"between t = {event.low:.10g} and {event.high:.10g}"
    return f"{event.drive} {what} its range from {low} to {high} {when}"
