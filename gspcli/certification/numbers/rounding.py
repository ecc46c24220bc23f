"""What rounding in floating point can change, and how the kernel says what it proved."""

#: Outward rounding of a sum or product of at most a few hundred nonnegative floats: each
#: operation loses a relative 2^-53 at most, and this factor makes up for four thousand of them.
OUTWARD = 1 + 2.0**-40

#: Less than this is lost where a result leaves the normal range of floats.
TINY = 2.0**-1000

#: Bounds the relative error (of the expression of the moduli) of everything computed here.
ROUNDING = 2.0**-45
#: A coefficient differs from its double by at most this part of its bound.
CONVERSION = 2.0**-50
#: Bits of what the kernel proves.
ISOLATED, REAL, COMPLEX, ROUNDED = 1, 2, 4, 8
