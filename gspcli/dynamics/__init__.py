"""Forces, motions and natural frequencies of platforms with masses."""

from gspcli.dynamics.drive_forces import DriveForces, inverse_dynamics
from gspcli.dynamics.forward import SimulatedMotion, forward_dynamics, simulate
from gspcli.dynamics.vibrations import NaturalModes, natural_modes

__all__ = [
    "DriveForces",
    "NaturalModes",
    "SimulatedMotion",
    "forward_dynamics",
    "inverse_dynamics",
    "natural_modes",
    "simulate",
]
