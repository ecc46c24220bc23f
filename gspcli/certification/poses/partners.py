"""The second of two solutions side by side, from the first.

Where data are a fold's but for eps, two solutions are sqrt(eps) apart, and Newton's method leads
from near both to either of them. Let J be the Jacobian at the one that is known, w and v its left
and right singular vectors of the smallest singular value. On the line through it along v the
component ``w . F`` is, but for higher terms, a parabola that is zero there: its other zero is near
the other solution.
"""

from __future__ import annotations

from flint import acb, acb_mat, arb, ctx

from gspcli.certification.numbers.balls import largest
from gspcli.certification.poses.locator import LAST_PRECISION, AtInfinity, Located, Locator

#: Solutions have another one side by side if their uniqueness is proved in smaller balls only.
_ALONE = 2.0**-20
#: Steps of inverse iteration towards singular vectors.
_STEPS = 3
#: Where the second derivative along the line is measured, as a part of the uniqueness.
_PART = 2.0**-10


def is_alone(pose: Located) -> bool:
    """Whether no other solution is side by side with a pose."""
    return pose.isolation.uniqueness > _ALONE


def partner(locator: Locator, pose: Located) -> Located | AtInfinity | None:
    """Return what is proved where the second of two solutions should be."""
    isolation = pose.isolation
    patch, sides = isolation.patch, isolation.sides
    free = [k for k in range(8) if k != patch]
    with ctx.workprec(LAST_PRECISION):
        system = locator.system(LAST_PRECISION)
        centre = list(isolation.centre)
        _, full = system.at(centre, sides)
        jacobian = acb_mat([[row[k].mid() for k in free] for row in full.tolist()])
        try:
            inverse = jacobian.inv().mid()
        except ZeroDivisionError:
            return None
        right, left = _singular(inverse), _singular(inverse.transpose())

        def along(a: arb) -> acb:
            moved = list(centre)
            for k, x in zip(free, right, strict=True):
                moved[k] = (moved[k] + a * x).mid()
            at, _ = system.at(moved, sides)
            return sum((w * y for w, y in zip(left, at.entries(), strict=True)), acb(0)).mid()

        h = arb(isolation.uniqueness * _PART)
        ahead, here, behind = along(h), along(arb(0)), along(-h)
        curvature = (ahead - 2 * here + behind).mid()
        if curvature.is_zero():
            return None
        way = (-(ahead - behind) / curvature * h).mid()
        for k, x in zip(free, right, strict=True):
            centre[k] = (centre[k] + way * x).mid()
        return locator.locate_exactly(centre, sides, isolation.precision)


def _singular(inverse: acb_mat) -> list[acb]:
    """Return about the right singular vector of a matrix's smallest singular value."""
    vector = acb_mat(7, 1, [acb(k + 1, 7 - k) for k in range(7)])
    adjoint = inverse.conjugate().transpose()
    for _ in range(_STEPS):
        vector = (inverse * (adjoint * vector)).mid()
        vector = (vector / largest(vector.entries())).mid()
    return [x.mid() for x in vector.entries()]
