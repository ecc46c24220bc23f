"""Proofs with 86 digits for many points at a time: what double precision cannot tell apart.

The theorem is that of `isolation` and the equations are those of `ball_system`, as numbers with 288
binary places, with which the native kernel computes; native/digits.cpp has the bounds of all
errors. It does for platforms that are special up to a shake, whose poses are far away and side
by side. Only equations that are single quadrics are treated, which leaves out distances of lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from flint import arb, ctx
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import Form
from gspcli.certification.numbers.balls import floats_above
from gspcli.certification.numbers.rounding import COMPLEX, ISOLATED, OUTWARD, REAL
from gspcli.certification.poses.locator import Locator

Complex = NDArray[np.complex128]

#: Binary places of a number, and the bytes of it (native/fixed.hpp).
_PLACES, _BYTES = 288, 56
#: Bits with which coefficients are computed.
_PRECISION = 320
#: Larger coefficients are left to balls; in units of the length scale they are about one.
_MOST = 2.0**100


class DigitPoses(NamedTuple):
    """What is proved about n points.

    Attributes
    ----------
    R, T
        The poses in length units of the instance, to the last place or two of doubles of their
        largest entry; shapes (n, 3, 3) and (n, 3), complex, real ones exactly real.
    quaternions
        Of the rotations, ``e.e = 1``, of either sign, shape (n, 4).
    proved
        Near which points there is exactly one solution, a simple one that is a pose, proved to be
        real or not to be; shape (n,).
    real
        Which of those are real, shape (n,).
    """

    R: Complex
    T: Complex
    quaternions: Complex
    proved: NDArray[np.bool_]
    real: NDArray[np.bool_]


class DigitProofs:
    """The equations of an instance with some sides of its planes, for proofs with 86 digits.

    Parameters
    ----------
    numbers
        The coefficients of ``e . f`` and of the equation of each constraint in the forms of
        `study`, in words of 64 bits; shape (7, 27, 7).
    error
        By how much any of them may be off.
    locator
        Of the instance.
    """

    def __init__(self, numbers: NDArray[np.uint64], error: float, locator: Locator) -> None:
        self._numbers = numbers
        self._error = error
        self._locator = locator

    @classmethod
    def of(cls, locator: Locator, sides: Sequence[int]) -> DigitProofs | None:
        """Return the equations, None if they are not single quadrics that say it all.

        Parameters
        ----------
        locator
            Of the instance.
        sides
            For each constraint the index of its equation (`BallSystem.equations`).
        """
        with ctx.workprec(_PRECISION):
            system = locator.system(_PRECISION)
            chosen = [each[side] for each, side in zip(system.equations, sides, strict=True)]
            if any(equation.squares for equation in chosen):
                return None
            # That of lines that meet holds where they are parallel, too, at any distance.
            if any(statement.kind is DLL for statement in system.statements):
                return None
            forms: list[Form] = [{study.STUDY: arb(1)}]
            forms += [system.forms[equation.main] for equation in chosen]
            given = [c for form in forms for c in form.values()]
            if not floats_above(given).max() < _MOST:
                return None
            whole = [_cut_off(c) for c in given]
            # What was cut off is less than one unit.
            error = (max(float(c.rad()) for c in given) + 2.0**-_PLACES) * OUTWARD
        numbers = np.zeros((len(forms), study.COUNT, _BYTES // 8), np.uint64)
        rows = [row for row, form in enumerate(forms) for _ in form]
        columns = [k for form in forms for k in form]
        words = b"".join(x.to_bytes(_BYTES, "little", signed=True) for x in whole)
        numbers[rows, columns] = np.frombuffer(words, "<u8").reshape(len(whole), -1)
        return cls(numbers, error, locator)

    def prove(self, points: Complex, low: Complex | None = None) -> DigitPoses:
        """Prove what can be proved about Study points.

        Parameters
        ----------
        points, low
            As for `Locator.locate`.
        """
        locator = self._locator
        frames, scale = locator.frames, locator.scale
        parts = [points[:, None]] if low is None else [points[:, None], low]
        R, T, quaternions, norms, bits = _kernel.prove_digits(
            self._numbers,
            study.form_hessians(),
            np.ascontiguousarray(np.concatenate(parts, axis=1)),
            error=self._error,
            unit=frames.length / scale,
            origins=np.array((frames.base, frames.platform)) / scale,
        )
        proved = ((bits & ISOLATED) > 0) & ((bits & (REAL | COMPLEX)) > 0)
        real = proved & ((bits & REAL) > 0)
        with np.errstate(all="ignore"):
            quaternions = quaternions / np.sqrt(norms)[:, None]
        for values in (R, T, quaternions):
            # The real part is no further from a real solution.
            values.imag[real] = 0
        # Exact: a power of two.
        return DigitPoses(R, T * scale, quaternions, proved, real)


def _cut_off(coefficient: arb) -> int:
    """Return the middle of a ball in units of the last place, rounded down."""
    digits, exponent = coefficient.mid().man_exp()
    shift = int(exponent) + _PLACES
    return int(digits) << shift if shift >= 0 else int(digits) >> -shift
