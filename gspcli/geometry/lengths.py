"""Units of length in metres."""

from __future__ import annotations

#: Names of units of length in metres. Kinematics is the same in any unit, so other names are only
#: carried along; where forces come in, a unit must be one of these.
METRES = {
    "m": 1.0,
    "dm": 0.1,
    "cm": 0.01,
    "mm": 1e-3,
    "um": 1e-6,
    "µm": 1e-6,
    "km": 1e3,
    "in": 0.0254,
    "inch": 0.0254,
    "ft": 0.3048,
}
