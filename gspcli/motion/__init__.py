"""Platforms that move: what poses measure, and what poses do when the values change."""

from gspcli.geometry.limits import out_of_range
from gspcli.motion.files.pose_files import PoseFormat, PoseTable, read_pose, read_poses
from gspcli.motion.files.value_files import ValueTable, read_values
from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform
from gspcli.motion.following.follower import Follower, FollowerReport, FollowerStatus
from gspcli.motion.following.tracks import Event, Track
from gspcli.motion.following.trajectories import track
from gspcli.motion.poses.cranks import crank_angles
from gspcli.motion.poses.inverse_kinematics import measure
from gspcli.motion.workspace.box_division import workspace
from gspcli.motion.workspace.travels import Travel, travels
from gspcli.motion.workspace.workspaces import Workspace

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
