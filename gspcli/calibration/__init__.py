"""From a measured machine to a calibrated file: the true numbers of a platform, with covariance."""

from gspcli.calibration.calibrating import calibrate, calibrate_rows
from gspcli.calibration.options import Options
from gspcli.calibration.results import Calibration

__all__ = ["Calibration", "Options", "calibrate", "calibrate_rows"]
