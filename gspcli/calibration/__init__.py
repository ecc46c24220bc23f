"""From a measured machine to a calibrated file: the true numbers of a platform, with covariance."""

from gspcli.calibration.calibrating import Calibration, Options, calibrate, calibrate_rows

__all__ = ["Calibration", "Options", "calibrate", "calibrate_rows"]
