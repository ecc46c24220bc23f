"""Forces and natural frequencies of platforms with masses."""

from gspcli.dynamics.forces import DriveForces, inverse_dynamics
from gspcli.dynamics.vibrations import NaturalModes, natural_modes

__all__ = ["DriveForces", "NaturalModes", "inverse_dynamics", "natural_modes"]
