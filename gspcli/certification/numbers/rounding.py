"""Bounds of rounding in floating point, and the bits with which the kernel reports proofs."""

#: Factor of outward rounding of a sum or product of at most a few hundred nonnegative floats: each
#: operation has a relative error of at most 2^-53, and the factor covers four thousand of them.
OUTWARD = 1 + 2.0**-40

#: A bound of the error where a result is below the normal range of floats.
TINY = 2.0**-1000

#: A coefficient differs from its double by at most this part of its bound.
CONVERSION = 2.0**-50
#: Bits of the properties that the kernel has proved.
ISOLATED, REAL, COMPLEX, ROUNDED = 1, 2, 4, 8
