"""Sensors that distinguish the real modes of a platform, and the mode that fits readings."""

from gspcli.sensing.api import sensors
from gspcli.sensing.identification import ReadingFit, fit_readings
from gspcli.sensing.result import SensorResult
from gspcli.sensing.sensor_kinds import Sensor

__all__ = ["ReadingFit", "Sensor", "SensorResult", "fit_readings", "sensors"]
