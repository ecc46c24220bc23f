"""Numbers that functions and commands use unless others are given; each is stated here alone."""

from __future__ import annotations

#: The seed of everything random: the same call gives the same bytes.
SEED = 20031
#: How long `maximize_real` searches, in seconds.
SEARCH_SECONDS = 60.0
#: How long `path` searches, in seconds.
PATH_SECONDS = 30.0
#: Largest difference of a pose from its solution that `certify` accepts; lengths by the
#: platform's size, relative for numbers above one.
TOLERANCE = 1e-6
#: Bits at which `certify` stops raising the precision.
MAX_PRECISION = 1024
#: Work that an exact count may take, in billions of multiplications modulo a prime, each of which
#: takes a second or two: while a platform is solved; if a function asks for it; with `gsp count`.
PATIENCE, COUNT_LIMIT, LONG_COUNT = 2.0, 5.0, 60.0
#: Digits of imported numbers, and the share of a machine's size up to which axes are taken to meet.
IMPORTED_DIGITS, MEETING_SHARE = 12, 1e-4
