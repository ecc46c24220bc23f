"""Bounds of rounding in floating point, and the bits with which the kernel reports proofs."""

#: The error of a number that is rounded to the nearest double is at most this part of it.
NEAREST = 2.0**-53

#: A bound of the error where a result is below the normal range of floats.
TINY = 2.0**-1000

#: A coefficient differs from its double by at most this part of its bound.
CONVERSION = 2.0**-50
#: Bits of the properties that the kernel has proved.
ISOLATED, REAL, COMPLEX, ROUNDED = 1, 2, 4, 8
