"""Sensors that distinguish the real modes of a platform, and the poses that fit readings."""

from gspcli.sensing.api import sensors
from gspcli.sensing.fitted_poses import PoseFit
from gspcli.sensing.identification import ReadingFit, fit_readings
from gspcli.sensing.pose_fitting import fit_poses
from gspcli.sensing.result import SensorResult
from gspcli.sensing.sensor_kinds import Sensor

__all__ = [
    "PoseFit",
    "ReadingFit",
    "Sensor",
    "SensorResult",
    "fit_poses",
    "fit_readings",
    "sensors",
]
