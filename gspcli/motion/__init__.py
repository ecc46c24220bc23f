"""Platforms that move: what poses measure, and what poses do when the values change."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gspcli.geometry.limits import out_of_range
from gspcli.motion.files.pose_files import PoseFormat, PoseTable, read_pose, read_poses
from gspcli.motion.files.value_files import ValueTable, read_values
from gspcli.motion.poses.cranks import crank_angles
from gspcli.motion.poses.inverse_kinematics import measure
from gspcli.motion.workspace.box_division import workspace
from gspcli.motion.workspace.travels import Travel, travels
from gspcli.motion.workspace.workspaces import Workspace

if TYPE_CHECKING:
    from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform
    from gspcli.motion.following.follower import Follower, FollowerReport, FollowerStatus
    from gspcli.motion.following.tracks import Event, Track
    from gspcli.motion.following.trajectories import track

#: What follows modes proves them, too: a third of the time that the rest of this room takes to
#: import, spent when it is used.
_HOMES = {
    "Event": "tracks",
    "FollowOptions": "branch_follower",
    "Follower": "follower",
    "FollowerReport": "follower",
    "FollowerStatus": "follower",
    "MovingPlatform": "branch_follower",
    "Track": "tracks",
    "track": "trajectories",
}

__all__ = [
    "Event",
    "FollowOptions",
    "Follower",
    "FollowerReport",
    "FollowerStatus",
    "MovingPlatform",
    "PoseFormat",
    "PoseTable",
    "Track",
    "Travel",
    "ValueTable",
    "Workspace",
    "crank_angles",
    "measure",
    "out_of_range",
    "read_pose",
    "read_poses",
    "read_values",
    "track",
    "travels",
    "workspace",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(f"gspcli.motion.following.{_HOMES[name]}"), name)
