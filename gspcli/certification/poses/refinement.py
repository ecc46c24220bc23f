"""A certified solution with any number of proved decimals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain

from flint import arb, ctx

from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.certification.equations.pose_balls import pose_of_point
from gspcli.certification.numbers.balls import float_above
from gspcli.certification.poses.certificates import Certificate
from gspcli.certification.poses.isolation import Isolation, refine_point
from gspcli.errors import IncompleteError
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass

Rows = tuple[tuple[str, str, str], tuple[str, str, str], tuple[str, str, str]]
Triple = tuple[str, str, str]

#: The most bits for each digit.
_BITS_A_DIGIT = 64


@dataclass(frozen=True)
class RefinedPose:
    """A solution in decimals.

    Every printed number differs from the exact one by less than 0.51 units of its last place.

    Attributes
    ----------
    R, T
        The rotation by rows and the translation in length units; real parts, if the
        solution is not proved real.
    R_imag, T_imag
        The imaginary parts, or None if the solution is proved real.
    precision
        Bits that were needed.
    """

    R: Rows
    T: Triple
    R_imag: Rows | None
    T_imag: Triple | None
    precision: int


def refine(instance: Instance, certificate: Certificate, digits: int) -> RefinedPose:
    """Return a certified solution to a number of proved digits.

    Parameters
    ----------
    instance
        The instance that was certified.
    certificate
        What `certify` returned for the solution.
    digits
        Decimals of the rotation, and significant digits of the largest number of T; all
        of T has the same number of decimals.

    Returns
    -------
    RefinedPose
        The numbers as decimal strings.

    Raises
    ------
    ValueError
        If the certificate proves nothing.
    IncompleteError
        If the digits need an unreasonable precision, or the solution is none of this instance.
    """
    isolation = certificate.isolation
    if not certificate.certified or isolation is None:
        message = f"there is nothing to refine: {certificate.outcome.meaning}"
        raise ValueError(message)
    instance = certificate.equivalent or instance
    local_frames = LocalFrames.of(instance)
    centre = list(isolation.centre)
    precision = isolation.precision
    while precision <= _BITS_A_DIGIT * (digits + 16) + 2 * isolation.precision:
        with ctx.workprec(precision):
            system = BallSystem(local_frames.applied(instance), precision)
            result = refine_point(system, centre, isolation.patch, isolation.sides)
            if isinstance(result, Isolation):
                centre = list(result.centre)
                refined = _printed(certificate, result, system.scale, local_frames, digits)
                if refined is not None:
                    return refined
        precision *= 2
    message = f"{digits} digits could not be proved with {precision // 2} bits"
    raise IncompleteError(message)


def _printed(
    certificate: Certificate,
    result: Isolation,
    scale: float,
    local_frames: LocalFrames,
    digits: int,
) -> RefinedPose | None:
    """Return the decimals, or None if the precision does not suffice."""
    pose = pose_of_point(result.point)
    proved = certificate.isolation
    if pose is None or proved is None or not proved.contains(result):
        return None
    turn = list(chain(*pose.rotation))
    shift = local_frames.back(pose.rotation, [entry * scale for entry in pose.translation])
    size = max(*(float_above(entry) for entry in shift), scale * 10.0**-digits)
    places = max(0, digits - math.floor(math.log10(size)) - 1)
    real = bool(certificate.real or result.real)
    parts = [
        _decimals([x.real for x in turn], digits),
        _decimals([x.real for x in shift], places),
        _decimals([x.imag for x in turn], digits),
        _decimals([x.imag for x in shift], places),
    ]
    R, T, R_imag, T_imag = parts
    if R is None or T is None or (not real and (R_imag is None or T_imag is None)):
        return None
    return RefinedPose(
        _rows(R),
        (T[0], T[1], T[2]),
        None if real or R_imag is None else _rows(R_imag),
        None if real or T_imag is None else (T_imag[0], T_imag[1], T_imag[2]),
        result.precision,
    )


def _rows(entries: Sequence[str]) -> Rows:
    a, b, c, d, e, f, g, h, i = entries
    return ((a, b, c), (d, e, f), (g, h, i))


def _decimals(values: Sequence[arb], places: int) -> list[str] | None:
    """Return numbers with this many places, or None if one of them is not accurate enough."""
    texts = []
    for value in values:
        shifted = value * arb(10) ** places
        nearest = (shifted.mid() + arb(0.5)).floor().unique_fmpz()
        if nearest is None or not abs(shifted - nearest) < 0.51:
            return None
        # Python refuses to write an integer of more than 4300 digits; FLINT does not.
        digits = str(abs(nearest)).rjust(places + 1, "0")
        whole, fraction = digits[: len(digits) - places], digits[len(digits) - places :]
        sign = "-" if nearest < 0 else ""
        texts.append(f"{sign}{whole}.{fraction}" if places else f"{sign}{whole}")
    return texts
