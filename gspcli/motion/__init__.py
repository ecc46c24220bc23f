"""Platforms that move: values at poses, and poses along changing values."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gspcli.motion.files.pose_files import PoseFormat, PoseTable, read_pose, read_poses
from gspcli.motion.files.value_files import ValueTable, read_values
from gspcli.motion.poses.inverse_kinematics import drive_values, measure

if TYPE_CHECKING:
    from gspcli.motion.collisions.compared import Gaps, gaps
    from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform
    from gspcli.motion.following.follower import Follower, FollowerReport, FollowerStatus
    from gspcli.motion.following.tracks import Departure, Event, Track, departures, track
    from gspcli.motion.paths.planned_paths import PlannedPath
    from gspcli.motion.paths.planner import ModeGroups, mode_groups, path
    from gspcli.motion.workspace.travels import Travel, travels
    from gspcli.motion.workspace.workspaces import Workspace

#: Names that are imported when they are used: following of modes and workspaces each take a third
#: of the time that the rest of this room takes to import.
_HOMES = {
    "Departure": "following.tracks",
    "Event": "following.tracks",
    "FollowOptions": "following.branch_follower",
    "Follower": "following.follower",
    "FollowerReport": "following.follower",
    "FollowerStatus": "following.follower",
    "Gaps": "collisions.compared",
    "ModeGroups": "paths.planner",
    "MovingPlatform": "following.branch_follower",
    "PlannedPath": "paths.planned_paths",
    "Track": "following.tracks",
    "Travel": "workspace.travels",
    "Workspace": "workspace.workspaces",
    "departures": "following.tracks",
    "gaps": "collisions.compared",
    "mode_groups": "paths.planner",
    "path": "paths.planner",
    "track": "following.tracks",
    "travels": "workspace.travels",
}

__all__ = [
    "Departure",
    "Event",
    "FollowOptions",
    "Follower",
    "FollowerReport",
    "FollowerStatus",
    "Gaps",
    "ModeGroups",
    "MovingPlatform",
    "PlannedPath",
    "PoseFormat",
    "PoseTable",
    "Track",
    "Travel",
    "ValueTable",
    "Workspace",
    "departures",
    "drive_values",
    "gaps",
    "measure",
    "mode_groups",
    "path",
    "read_pose",
    "read_poses",
    "read_values",
    "track",
    "travels",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(f"gspcli.motion.{_HOMES[name]}"), name)
