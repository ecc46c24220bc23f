"""Platforms that move: what poses measure, and what poses do when the values change."""

from gspcli.motion.measuring import measure
from gspcli.motion.pose_files import PoseFormat, PoseTable, read_pose, read_poses

__all__ = ["PoseFormat", "PoseTable", "measure", "read_pose", "read_poses"]
