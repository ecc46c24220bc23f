"""A body that is small beside the lengths of the platform, and the platforms with larger ones.

If the points of a body are at the distance eps from each other, the distances of one point nearly
determine all others. There are poses at which R is about as large as 1 / eps.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, ctx

from gspcli.certification.equations.statement import statements
from gspcli.certification.numbers.balls import norm
from gspcli.certification.poses.special_family import DIFFERENCE_BITS, SpecialFamily
from gspcli.geometry.instance import Instance
from gspcli.geometry.tolerances import SMALL_BODIES


def small_bodies(instance: Instance) -> SpecialFamily | None:
    """Return a platform among those with the smaller body larger.

    The result is None if no body is small.
    """
    with ctx.workprec(DIFFERENCE_BITS):
        given = statements(instance)
        bodies = [(name, _from_first([getattr(row, name) for row in given])) for name in "ab"]
        sizes = [max(float(norm(x).mid()) for x in body) for _, body in bodies]
    size = min(sizes)
    name, body = bodies[sizes.index(size)]
    least, most = SMALL_BODIES
    if not least < size < most:
        return None
    return SpecialFamily(instance, tuple({name: x} if any(x) else {} for x in body), size)


def _from_first(points: Sequence[Sequence[arb]]) -> list[list[arb]]:
    """Return points less the first of them."""
    return [[x - y for x, y in zip(point, points[0], strict=True)] for point in points]
