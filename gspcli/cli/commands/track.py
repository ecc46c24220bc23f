"""`gsp track`: follows the assembly modes while the values change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gspcli.cli import options, pose_options
from gspcli.cli.render import emit
from gspcli.cli.requirements import judged, measured_quantities, refuse, require_option, required
from gspcli.cli.result import Fields, Result, pose_columns
from gspcli.cli.streams import say, working
from gspcli.errors import GspError, IncompleteError
from gspcli.geometry.machine import Machine
from gspcli.records import dataclass
from gspcli.wording import counted, listed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Array, Instance
    from gspcli.motion import Event, Track, ValueTable
    from gspcli.motion.files.requirements import QuantityParts, Requirement, RequirementVerdict
    from gspcli.motion.following.tracks import Departure
    from gspcli.motion.paths.between import LimitEvent
    from gspcli.motion.paths.ways import PoseWays

FIELDS = Fields("track")


@click.command(cls=options.Command)
@options.exclusive("--mode", "--near")
@click.argument("spec", metavar="SPEC")
@click.argument("values", metavar="VALUES")
@pose_options.mode_option("only this one is followed.")
@pose_options.near_option("only this one is followed")
@options.value_options
@options.option(
    "--steps",
    "Write N rows for each row of VALUES, evenly between it and the next one.",
    type=options.Whole(1),
    default=1,
)
@options.option(
    "--along",
    "What changes linearly between rows; of a file of poses it can be x, y, z and the angles.",
    type=click.Choice(["values", "poses"]),
    default="values",
)
@options.option("--relative", "The values in the file are added to those of SPEC.")
@options.option(
    "--all-modes",
    "All real poses: along a file of poses follow all, not only the mode of these poses.",
)
@options.option(
    "--complete",
    "Compare with all poses at the last row, and follow modes that begin on the way, too.",
    name="everything",
)
@options.option("--allow-loss", "Exit with 0 though a mode ends on the way.")
@options.option(
    "--clearance",
    "Add how far all values may change with proof that nothing is singular (gsp clearance).",
    name="clear",
)
@options.option(
    "--pose-clearance",
    "Add how far the pose may move, for any values, with proof that its screws stay independent "
    "(gsp clearance --of pose).",
    name="pose_clear",
)
@require_option("range, cone, clearance>=0.5, condition<=50")
@pose_options.pose_options
@pose_options.column_options
@options.jobs_option
@options.output_options()
def command(o: options.Options) -> None:
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

    requirements = required(o.require)
    form = o.form
    table = read_values(*pose_options.text_of(o.values), o.instance, form, delta=o.relative)
    done = _along_poses(o, table) if o.along == "poses" else _along_values(o, table)
    result, limits, left = done.track, done.limits, done.left
    with working("looking for singularities"):
        more = _clearances(o, result, requirements)
    rows = result.rows(more, form.frame)
    shown = _track_table(result, rows, limits, form.frame)
    head: dict[str, Any] = {**shown.head, "limits": [*map(_plain_limit, limits)]}
    head |= {"requirements": []} if requirements else {}
    head["departures"] = [one.to_json(form.in_radians) for one in left]
    shown = replace(shown, head=head)
    verdicts: list[RequirementVerdict] = []
    if requirements:
        verdicts, quantities = _judged_track(done, requirements, rows)
        numbers = {
            t: k // o.steps + 1 for k, t in enumerate(dict.fromkeys(row["t"] for row in rows))
        }
        places = [{"row": numbers[row["t"]], "t": row["t"], "mode": row["mode"]} for row in rows]
        shown = judged(shown, verdicts, quantities, places, between=True)
    emit(o.output, shown)
    if o.output.format != "json":
        for line in (
            *_new_modes(result),
            *map(_event_sentence, result.events),
            *_limit_sentences(result, limits),
        ):
            say(line)
    _refuse_losses(result, left, allowed=o.allow_loss)
    refuse(verdicts)


def _clearances(
    o: options.Options, result: Track, requirements: list[Requirement]
) -> dict[str, Array]:
    """Return the clearances that are asked for, by their names in rows, each of shape (m, r)."""
    asked = {one.quantity for one in requirements}
    found = {}
    if o.clear or "clearance" in asked:
        from gspcli.geometry.machine import Machine, value_machine
        from gspcli.motion.paths.between import drive_rows, moves_by_drives
        from gspcli.motion.singularities.clearances import clearances

        if moves_by_drives(result):
            machine, there = Machine.of(result.instance), ~np.isnan(result.T[..., 0])
            q = np.tile(drive_rows(result, machine), (len(there), 1, 1))[there]
            pose = result.R[there], result.T[there]
            modes = machine.modes_at(*pose, q)
            found["clearance"] = np.full(there.shape, np.nan)
            found["clearance"][there] = clearances(machine, *pose, working_modes=modes)[0]
        else:
            found["clearance"] = _at_poses(
                result,
                lambda instance, *pose: clearances(value_machine(instance), *pose)[0],
                result.instances(),
            )
    if o.pose_clear or "pose-clearance" in asked:
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
        verb = f"s {names} end" if len(result.ends) > 1 else f" {names} ends"
        raise IncompleteError(
            f"mode{verb} before the last row\nuse --allow-loss if that is expected"
        )
    if left:
        first, units = left[0], result.instance.units
        rows = len({one.row for one in left})
        more = f" (and at {counted(rows - 1, 'more row')})" if rows > 1 else ""
        turn = first.turn / units.angle.in_radians
        raise IncompleteError(
            f"row {first.row + 1} (t = {first.t:.6g}): mode {first.mode} is not at the pose of the "
            f"file, but {first.distance:.3g} {units.length} and {turn:.3g} {units.angle.value} "
            f"away{more}\nbetween rows the values change linearly, and another pose has these "
            f"values, too\ngive more poses before row {max(first.row + 1, 2)}"
        )


def _new_modes(result: Track) -> list[str]:
    """Say which modes have no number of `gsp solve SPEC`, if any."""
    if not result.new:
        return []
    names = ", ".join(map(str, result.new))
    if not result.known:
        return [f"mode {names}: new, for SPEC has no numbers to carry to the first row"]
    return [
        f"mode{'s' if len(result.new) > 1 else ''} {names}: new, not reached from the "
        f"{result.known} real poses of SPEC on the way to the first row"
    ]


def _at_poses(
    result: Track,
    bound: Callable[[Instance, Array, Array], Array],
    parts: Iterable[tuple[slice, Instance]],
) -> Array:
    """Return what is bounded at each pose, shape (m, r); NaN where a mode is not.

    Each part has rows, and the platform there.
    """
    found = np.full(result.T.shape[:2], np.nan)
    for rows, instance in parts:
        there = np.zeros(found.shape, bool)
        there[:, rows] = ~np.isnan(result.T[:, rows, 0])
        found[there] = bound(instance, result.R[there], result.T[there])
    return found


def _track_table(
    result: Track, rows: list[dict[str, Any]], limits: list[LimitEvent], frame: PoseFrame
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
    note = (
        f"{counted(len(result.modes), 'mode')}, {len(result.modes) - len(result.events)} of them "
        f"from the first row to the last, {'proved' if result.certified else 'not proved'}"
    )
    if result.complete:
        note += "; every real pose at the last row is accounted for"
    notes = [note, *_cones_notes(result, limits), *pose_options.frame_note(frame)]
    title = result.instance.title
    return Result(columns, rows, title, notes, schema="track", name="poses", head=document)


def _event_sentence(event: Event) -> str:
    """Return an event of a mode between rows, in words."""
    if event.kind == "undecided":
        what = "cannot be followed back before" if event.begins else "cannot be followed beyond"
        t = event.high if event.begins else event.low
        return f"mode {event.mode} {what} t = {t:.10g}: {event.reason} (undecided)"
    partner = "another" if event.partner is None else f"mode {event.partner}"
    what, end = ("begins with", "") if event.begins else ("meets", " and ends")
    return f"mode {event.mode} {what} {partner} in a fold at t = {event.low:.12g}{end}, proved"


@dataclass(frozen=True, eq=False)
class _FollowedTrack:
    """A track, with its limits and events."""

    #: What was followed.
    track: Track
    #: Where ranges and cones are left.
    limits: list[LimitEvent]
    #: Where it is not at the poses of the file.
    left: list[Departure]
    #: The straight ways in position and angles from row to row; None for ways of values.
    ways: PoseWays | None = None
    #: The frame of the poses of these ways; None for the platform's own.
    frame: PoseFrame | None = None


def _along_values(o: options.Options, table: ValueTable) -> _FollowedTrack:
    """Follow modes while the values change linearly."""
    from gspcli.motion import departures, track
    from gspcli.motion.paths.between import limit_events

    table = table.subdivided(o.steps)
    if o.near is not None:
        start = o.near.read(o.form)
    else:
        start = None if o.mode is not None or o.all_modes or o.everything else table.start
    modes = None if o.mode is None else [pose_options.mode_number(o.instance, o.mode)]
    with working("following"):
        result = track(
            o.instance, table.values, coordinates=table.coordinates, t=table.t, modes=modes,
            near=start, everything=o.everything, jobs=o.jobs,
        )  # fmt: skip
    if not o.everything and not len(result.modes):
        raise GspError(
            "there is no real pose at the first row\n"
            "begin with other values, or use --complete for modes that begin on the way"
        )
    with working("looking at limits"):
        limits = limit_events(result)
    left = [] if table.poses is None else departures(result, *table.poses)
    return _FollowedTrack(result, limits, left)


def _along_poses(o: options.Options, table: ValueTable) -> _FollowedTrack:
    """Prove the straight ways in position and angles between the poses of a file."""
    from gspcli.geometry.expressed_instances import expressed_instance
    from gspcli.geometry.readings import without_corrections
    from gspcli.motion import track
    from gspcli.motion.paths.between import pose_track

    if table.poses is None:
        raise click.UsageError("--along poses is about a file of poses: found values")
    if o.mode is not None or o.near is not None or o.all_modes or o.everything:
        raise click.UsageError(
            "--along poses follows the poses of the file: leave out --mode, --near, "
            "--all-modes and --complete"
        )
    with working("proving"):
        # Its only row determines the mode at which the file begins.
        at = {name: column[:1] for name, column in table.coordinates.items()}
        first = track(o.instance, table.values[:1], coordinates=at, near=table.start)
        given, frame = without_corrections(o.instance), o.form.pivot_frame
        expressed = given
        if not frame.is_identity:
            relative = o.relative_to is not None
            expressed = expressed_instance(given, pivot=o.form.pivot, relative=relative)
        found = pose_track(
            given, expressed, frame, table.t, *table.poses, sequence=o.form.euler or "ZYX",
            mode=int(first.modes[0]), steps=o.steps,
        )  # fmt: skip
    # Readings are those of the file.
    result = replace(found.track, instance=o.instance)
    return _FollowedTrack(result, list(found.limits), [], found.ways, frame)


#: Quantities that have their columns in every track, or by options.
_KNOWN = ("condition", "clearance", "pose_clearance")


def _judged_track(
    done: _FollowedTrack, requirements: Sequence[Requirement], rows: list[dict[str, Any]]
) -> tuple[list[RequirementVerdict], dict[str, Array | QuantityParts]]:
    """Return whether a track keeps what is required, and quantities that its rows do not have."""
    from gspcli.motion.files.requirements import judge

    known = {
        key.replace("_", "-"): np.array([row[key] for row in rows])
        for key in _KNOWN
        if all(key in row for row in rows)
    }
    more = {
        one.quantity: _at_all_rows(done.track, one)
        for one in requirements
        if one.quantity not in known
    }
    return [_between(one, done) for one in judge(requirements, {**known, **more})], more


def _at_all_rows(result: Track, requirement: Requirement) -> Array | QuantityParts:
    """Return a quantity of each pose, in the order of the rows; the geometry may move."""
    from gspcli.motion.files.requirements import QuantityParts
    from gspcli.motion.paths.between import drive_rows

    name, instance = requirement.quantity, result.instance
    if name in ("range", "transmission", "gap"):
        rows, modes = np.nonzero(~np.isnan(result.T[..., 0].T))
        R, T = (array[modes, rows] for array in (result.R, result.T))
        q = drive_rows(result, Machine.of(instance))[rows]
        return measured_quantities(instance, [requirement], R, T, q=q)[name]
    found: list[Array | QuantityParts] = []
    for part, moved in result.instances():
        rows, modes = np.nonzero(~np.isnan(result.T[:, part, 0].T))
        R, T = (array[:, part][modes, rows] for array in (result.R, result.T))
        found.append(measured_quantities(moved, [requirement], R, T)[name])
    first = found[0]
    if isinstance(first, QuantityParts):
        every = [part.values for part in found if isinstance(part, QuantityParts)]
        return QuantityParts(np.concatenate(every), first.names)
    return np.concatenate([part for part in found if not isinstance(part, QuantityParts)])


def _between(verdict: RequirementVerdict, done: _FollowedTrack) -> RequirementVerdict:
    """Return a verdict that also holds between the rows, where that can be proved."""
    from gspcli.motion.paths.between import BOUNDED, can_be_bounded, cones_proved

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


def _bounded(verdict: RequirementVerdict, done: _FollowedTrack) -> RequirementVerdict:
    """Return a verdict on a quantity of `BOUNDED` that also holds between the rows."""
    from gspcli.motion.paths.between import worst_between

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


def _plain_limit(event: LimitEvent) -> dict[str, Any]:
    """Return an event as plain data."""
    return {
        "kind": event.kind,
        "leaves": event.leaves,
        "constraint": event.constraint + 1,
        "body": event.body or None,
        "mode": event.mode,
        "t": [event.low, event.high],
        "proved": event.proved,
        **({"drive": event.drive} if event.drive else {}),
    }


def _cones_notes(result: Track, events: list[LimitEvent]) -> list[str]:
    """Return which modes are proved to keep all cones, where there are any and anything is."""
    from gspcli.motion.paths.between import cones_proved

    if not Machine.of(result.instance).cones or not cones_proved(result):
        return []
    leaving = {event.mode for event in events if event.kind != "dead point"}
    modes = [mode for mode in result.modes.tolist() if mode not in leaving]
    if not modes:
        return ["no mode keeps all cones from beginning to end"] if leaving else []
    every = len(modes) == len(result.modes) > 1
    names = "all modes keep" if every else _keep("mode", modes)
    return [f"{names} all cones from beginning to end, between rows too: proved"]


def _keep(noun: str, numbers: Sequence[int]) -> str:
    """Return the beginning of a sentence: ``mode 1 keeps``, ``legs 1 and 2 keep``."""
    noun, verb = (f"{noun}s", "keep") if len(numbers) > 1 else (noun, "keeps")
    return f"{noun} {listed(map(str, numbers), 'and')} {verb}"


def _limit_sentences(result: Track, events: list[LimitEvent]) -> list[str]:
    """Return in words where limits are left and kept again.

    Cones of one mode about which nothing is known at one time share a sentence.
    """
    from gspcli.motion.paths.between import cones_proved

    found, certain = [], cones_proved(result)
    for (proved, mode, *_), same in groupby(
        events, lambda event: (event.proved, event.mode, event.low, event.high)
    ):
        together = [*same]
        cones = [one for one in together if certain and not proved and one.kind == "cone"]
        found += [_limit_sentence(result, one) for one in together if one not in cones]
        if cones:
            legs = sorted({one.constraint + 1 for one in cones})
            kept = f"{_keep('leg', legs)} {'their cones' if len(legs) > 1 else 'its cone'}"
            found.append(f"mode {mode}: whether {kept} {_interval(cones[0])} is undecided")
    return found


def _interval(event: LimitEvent) -> str:
    return f"between t = {event.low:.10g} and {event.high:.10g}"


def _limit_sentence(result: Track, event: LimitEvent) -> str:
    """Return where one limit is left or kept again, or a dead point is passed."""
    what = "leaves" if event.leaves else "comes back into"
    if event.high == result.t[0]:
        what = "is outside"
    certain, number = event.proved or event.low == event.high, event.constraint + 1
    if event.kind == "dead point":
        subject = f"mode {event.mode}: rod {number} passes a dead point of {event.drive}"
        return f"{subject} {_interval(event)}"
    if event.kind == "cone":
        when = f"at t = {event.low:.9g}" if certain else _interval(event)
        when += ", proved" if event.proved else ""
        return f"mode {event.mode}: leg {number} {what} its cone at the {event.body} {when}"
    if event.drive:
        drives = Machine.of(result.instance)
        k = drives.names.index(event.drive)
        low, high = (f"{drives.readings(end)[k]:.10g}" for end in (drives.low, drives.high))
    else:
        row = result.instance.constraints[event.constraint]
        low, high = map(str, map(row.reading_of, row.limits or ()))
    subject = event.drive or f"the value of constraint {number}"
    if certain:
        return f"{subject} {what} its range from {low} to {high} at t = {event.low:.10g}"
    return f"{subject} may leave its range from {low} to {high} {_interval(event)}"
