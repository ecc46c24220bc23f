"""Sensors that distinguish the real modes of a platform, and the poses that fit readings."""

from gspcli.sensing.pose_fitting import PoseFit, ReadingFit, fit_poses, fit_readings
from gspcli.sensing.sensor_kinds import Sensor
from gspcli.sensing.separations import SensorResult, sensors

__all__ = [
    "PoseFit",
    "ReadingFit",
    "Sensor",
    "SensorResult",
    "fit_poses",
    "fit_readings",
    "sensors",
]
