"""What `gsp track` follows: values or poses that change linearly between rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from gspcli.cli.progress_bars import working
from gspcli.errors import GspError
from gspcli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.cli.pose_options import PoseConventions
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat, Track, ValueTable
    from gspcli.motion.following.departures import Departure
    from gspcli.motion.following.limit_event import LimitEvent
    from gspcli.motion.paths.pose_ways import PoseWays

    Array = NDArray[np.float64]


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
    certify: bool,
    jobs: int,
) -> FollowedTrack:
    """Follow modes while the values change linearly; arguments as for `gspcli.track`."""
    from gspcli.motion import departures, track
    from gspcli.motion.following.limit_events import limit_events

    with working("following"):
        result = track(
            instance,
            table.values,
            coordinates=table.coordinates,
            t=table.t,
            modes=modes,
            near=near,
            everything=everything,
            certify=certify,
            jobs=jobs,
        )
    if not everything and not len(result.modes):
        message = (
            "there is no real pose at the first row\n"
            "begin with other values, or use --complete for modes that begin on the way"
        )
        raise GspError(message)
    with working("looking at limits"):
        limits = limit_events(result)
    left = [] if table.poses is None else departures(result, *table.poses)
    return FollowedTrack(result, limits, left)


def along_poses(
    instance: Instance,
    table: ValueTable,
    form: PoseFormat,
    conventions: PoseConventions,
    steps: int,
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
            expressed = expressed_instance(
                given, pivot=form.pivot, relative=conventions.relative_to is not None
            )
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
