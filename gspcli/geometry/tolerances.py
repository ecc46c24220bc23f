"""Tolerances below which directions count as parallel: one for each purpose, its unit in its name.

A sine is the norm of the vector product of two unit directions; for small angles it is the angle in
radians. The purposes differ in the number of correct digits.
"""

from __future__ import annotations

#: Zero up to the rounding of doubles: the lines have no unique common perpendicular and are
#: measured as parallel ones.
PARALLEL_SINE = 1e-9
#: Zero up to rounding, for the numbers of a file, which are exact.
PARALLEL_SINE_IN_FILES = 1e-12
#: Zero up to the errors of corrected poses, of sensors, and of machines described in doubles.
MEASURED_PARALLEL_SINE = 1e-6
#: Nearly parallel: the equation of a DLL nearly holds at any distance, and doubles do not prove its
#: poses.
NEARLY_PARALLEL_SINE = 1e-2
#: The square of the sine of two lines below which their distance is measured with more digits:
#: doubles lose half as many digits as it has zeros.
NEARLY_PARALLEL_SINE_SQUARE = 1e-8
#: Angles in radians between which directions of a body are turned apart to find poses far away.
#: Above the second, paths with 32 digits find them; below the first, bounds are no floats.
TURNED_APART_RADIANS = (1e-62, 1e-4)
#: Distances of points from a line, as parts of the distance of two points on it, from which they
#: are moved off to find poses far away. Above the second, paths with 32 digits find them; below
#: the first, bounds are no floats.
OFF_LINES = (1e-62, 1e-4)
