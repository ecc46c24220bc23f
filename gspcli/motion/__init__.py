"""Platforms that move: what poses measure, and what poses do when the values change."""

from gspcli.geometry.limits import out_of_range
from gspcli.motion.box_division import workspace
from gspcli.motion.cranks import crank_angles
from gspcli.motion.following import FollowOptions, MovingPlatform
from gspcli.motion.measuring import measure
from gspcli.motion.pose_files import PoseFormat, PoseTable, read_pose, read_poses
from gspcli.motion.tracks import Event, Track
from gspcli.motion.trajectories import track
from gspcli.motion.travels import Travel, travels
from gspcli.motion.value_files import ValueTable, read_values
from gspcli.motion.workspaces import Workspace

__all__ = [
    "Event",
    "FollowOptions",
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
