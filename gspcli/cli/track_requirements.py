"""``--require`` along a track: at all rows of all modes, and limits between rows, too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from gspcli.cli.requirements import (
    add_quantities,
    measured_quantities,
    verdict_entries,
    verdict_lines,
)
from gspcli.errors import GspError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.cli.output import Column
    from gspcli.cli.track_ways import FollowedTrack
    from gspcli.motion import Track
    from gspcli.motion.files.requirements import QuantityParts, Requirement, RequirementVerdict

    Array = NDArray[np.float64]

#: Quantities that have their columns in every track, or by options.
_KNOWN = ("condition", "clearance", "pose_clearance")


def judged_track(
    done: FollowedTrack,
    requirements: Sequence[Requirement],
    rows: list[dict[str, Any]],
) -> tuple[list[RequirementVerdict], list[Column]]:
    """Return whether a track keeps what is required, and the columns that this adds to its rows.

    Parameters
    ----------
    done
        The track, and where it leaves limits.
    requirements
        What is required.
    rows
        A row for each pose, in the order of the rows of the file, then of the modes.
    """
    if not requirements:
        return [], []
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
    return verdicts, add_quantities(rows, more)


def _at_all_rows(result: Track, requirement: Requirement) -> Array | QuantityParts:
    """Return a quantity of each pose, in the order of the rows; the geometry may move."""
    import numpy as np

    from gspcli.geometry.drive_numbers import arms_of, is_driven
    from gspcli.motion.files.requirements import QuantityParts
    from gspcli.motion.following.drive_events import moves_drives_only

    name = requirement.quantity
    if name in ("range", "transmission") and is_driven(result.instance):
        return _of_drives(result, name)
    if name == "gap" and is_driven(result.instance) and moves_drives_only(result):
        return _gaps(result)
    if name in ("clearance", "pose_clearance") and is_driven(result.instance):
        rows, modes = np.nonzero(~np.isnan(result.T[..., 0].T))
        R, T = (array[modes, rows] for array in (result.R, result.T))
        values = result.values[rows]
        return measured_quantities(result.instance, [requirement], values, R, T)[name]
    if name == "gap" and arms_of(result.instance):
        message = "--require gap: not known of arms while coordinates of points move"
        raise GspError(message)
    found: list[Array | QuantityParts] = []
    for part, moved in result.instances():
        # What is followed has one side of each plane; ranges are those of the sides asked for.
        instance = result.instance if name == "range" else moved
        rows, modes = np.nonzero(~np.isnan(result.T[:, part, 0].T))
        values = result.values[part][rows]
        R, T = (array[:, part][modes, rows] for array in (result.R, result.T))
        found.append(measured_quantities(instance, [requirement], values, R, T)[name])
    first = found[0]
    if isinstance(first, QuantityParts):
        every = [part.values for part in found if isinstance(part, QuantityParts)]
        return QuantityParts(np.concatenate(every), first.names)
    return np.concatenate([part for part in found if not isinstance(part, QuantityParts)])


def _of_drives(result: Track, name: str) -> QuantityParts:
    """Return shares of ranges or transmissions of each pose where the drives are known."""
    import numpy as np

    from gspcli.cli.requirements import limits_of
    from gspcli.geometry.drives import Drives
    from gspcli.motion.following.drive_events import drive_rows

    drives = Drives.of(result.instance)
    rows, modes = np.nonzero(~np.isnan(result.T[..., 0].T))
    R, T = (array[modes, rows] for array in (result.R, result.T))
    at = drives, drive_rows(result, drives)[rows]
    return limits_of(result.instance, name, result.values[rows], R, T, at)


def _gaps(result: Track) -> QuantityParts:
    """Return gaps of each pose, with the points where the drives have them."""
    import numpy as np

    from gspcli.cli.requirements import gaps_of
    from gspcli.geometry.drives import Drives
    from gspcli.motion.following.drive_events import drive_rows

    rows, modes = np.nonzero(~np.isnan(result.T[..., 0].T))
    R, T = (array[modes, rows] for array in (result.R, result.T))
    q = drive_rows(result, Drives.of(result.instance))[rows]
    return gaps_of(result.instance, R, T, q)


def _between(verdict: RequirementVerdict, done: FollowedTrack) -> RequirementVerdict:
    """Return a verdict that also holds between the rows, where that can be proved."""
    from gspcli.motion.following.limit_events import cones_proved
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


def track_lines(
    verdicts: Sequence[RequirementVerdict], rows: list[dict[str, Any]], steps: int
) -> list[str]:
    """Return the verdicts in lines; of `steps` rows of the track one is of the file."""

    def place(k: int) -> str:
        at = _place(rows, k, steps)
        return f"in row {at['row']} (t = {at['t']:.6g}), mode {at['mode']}"

    return verdict_lines(verdicts, place)


def track_entries(
    verdicts: Sequence[RequirementVerdict], rows: list[dict[str, Any]], steps: int
) -> dict[str, Any]:
    """Return the verdicts for JSON, under their key; nothing if nothing was required."""
    if not verdicts:
        return {}
    entries = verdict_entries(verdicts, lambda k: _place(rows, k, steps))
    judged = [{**one, "between": v.between} for one, v in zip(entries, verdicts, strict=True)]
    return {"requirements": judged}


def _place(rows: Sequence[Mapping[str, Any]], k: int, steps: int) -> dict[str, Any]:
    times = list(dict.fromkeys(row["t"] for row in rows))
    row = rows[k]
    return {"row": times.index(row["t"]) // steps + 1, "t": row["t"], "mode": row["mode"]}
