"""Arcs and folds of made-up curves: nothing false is proved of what lies on them.

A curve is p(z, t) = 0 in two of the nine unknowns; the other seven are zero.
"""

from __future__ import annotations

from types import SimpleNamespace

import flint
import numpy as np
import pytest
from flint import arb, arb_mat, arb_poly

from gspcli.catalogue.names import parse_type
from gspcli.certification.branches.curves import Arc, Fold, _krawczyk, _Turn, at_time
from gspcli.certification.branches.parametric_quadrics import moving_equations
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import MovingPlatform
from gspcli.motion.following.tracks import _same

NOTHING = [arb(0)] * 9


@pytest.fixture(autouse=True)
def _precision():
    with flint.ctx.workprec(160):
        yield


class Curve:
    """A polynomial in z and t, by its coefficients: ``{(1, 0): 1}`` is z."""

    gauge = (arb(1), *[arb(0)] * 7)

    def __init__(self, coefficients: dict[tuple[int, int], float]) -> None:
        self.coefficients = coefficients

    def along(self, x, v, order):
        z, t = (arb_poly([x[k], v[k]]) for k in (0, 8))

        def value(coefficients):
            terms = (arb(c) * z**i * t**j for (i, j), c in coefficients.items() if c)
            return sum(terms, arb_poly([0]))

        by_z = {(i - 1, j): i * c for (i, j), c in self.coefficients.items() if i}
        by_t = {(i, j - 1): j * c for (i, j), c in self.coefficients.items() if j}
        parts = [value(one) for one in (self.coefficients, by_z, by_t)]
        found = []
        for power in range(order + 1):
            here, slope, moves = (part[power] for part in parts)
            others = [(x, v)[power][k] if power < 2 else arb(0) for k in range(1, 8)]
            rows = [[arb(int(k == i and not power)) for k in range(9)] for i in range(8)]
            rows[0][0], rows[0][8] = slope, moves
            found.append(([here, *others], arb_mat(rows)))
        return found


def place(z: float, t: float) -> list[arb]:
    return [arb(z), *[arb(0)] * 7, arb(t)]


#: Two lines that cross at zero, t = z and t = -z, and two that nearly do.
CROSSING = {(0, 2): 1, (2, 0): -1}
GAP = 1e-2
NEARLY = {(0, 2): 1, (2, 0): -1, (0, 0): -(GAP**2)}


@pytest.mark.parametrize("gauge", [place(0.5, 0.5), place(0, 1), place(1, 0)])
def test_no_arc_leads_across_a_crossing(gauge) -> None:
    curve, centre, direction = Curve(CROSSING), place(-0.1, -0.1), place(1, 1)
    arc = Arc(curve, centre, direction, gauge)
    assert arc.holds(arb(0.02), NOTHING)
    for reach in (0.101, 0.11, 0.15, 0.2, 0.5, 2):
        assert not arc.holds(arb(reach), NOTHING)
    # A box about the arc that is as wide as the other line is far.
    for width in (0.11, 0.2, 0.5):
        assert not arc.holds(arb(0.02), place(width, width))


def test_a_box_that_holds_has_just_the_points_of_the_curve() -> None:
    """Of t^2 = z^2 + e^2 the branch above: t is a function of z, and the other one is not near."""
    curve = Curve(NEARLY)
    for z in (-0.05, 0.0, 0.003, 0.05):
        t = float(np.sqrt(z * z + GAP**2))
        arc = Arc(curve, place(z, t), place(1, z / t), place(1, 0))
        claims = 0
        for reach in (1e-3, 3e-3, 0.01, 0.02, 0.05, 0.2):
            if not arc.holds(arb(reach), NOTHING):
                continue
            claims += 1
            for s in np.linspace(-reach, reach, 21):
                middle, width = t + s * z / t, float(arc.widths[8].mid())
                inside = [
                    sign * np.sqrt((z + s) ** 2 + GAP**2)
                    for sign in (1, -1)
                    if abs(sign * np.sqrt((z + s) ** 2 + GAP**2) - middle) <= width * 1.0001
                ]
                assert len(inside) == 1
        assert claims


def test_a_box_that_newtons_method_leaves_does_not_hold() -> None:
    """Of t - t^2 = 0.24 Newton's step from 0 is 0.24, and the solution is 0.4."""
    for constant, holds in ((0.05, True), (0.24, False), (0.26, False)):
        curve = Curve({(0, 0): -constant, (0, 1): 1, (0, 2): -1})
        arc = Arc(curve, place(0, 0), place(1, 0), place(1, 0))
        assert arc.holds(arb(1e-3), NOTHING) is holds


def test_an_arc_ends_at_its_reach() -> None:
    arc = Arc(Curve({(0, 1): 1, (1, 0): -1}), place(0, 0), place(1, 1), place(1, 0))
    assert arc.holds(arb(0.1), NOTHING)
    assert arc.contains(place(0.09, 0.09))
    assert not arc.contains(place(0.11, 0.11))
    assert not arc.contains([arb(0.095, 0.01), *[arb(0)] * 7, arb(0.095)])
    assert not arc.contains([arb(0.05), *[arb(0)] * 7, arb(0.05, 0.01)])


def test_where_time_turns_back_the_arc_says_so() -> None:
    """t = z^3 bends both ways about zero, t = z^2 one way."""
    for coefficients, sign in (({(0, 1): 1, (2, 0): -1}, 1), ({(0, 1): 1, (2, 0): 1}, -1)):
        arc = Arc(Curve(coefficients), place(0, 0), place(1, 0), place(1, 0))
        assert arc.holds(arb(0.1), NOTHING)
        assert arc.bends() == sign
    for z in (-0.05, 0.0, 0.05):
        arc = Arc(Curve({(0, 1): 1, (3, 0): -1}), place(z, z**3), place(1, 3 * z * z), place(1, 0))
        assert arc.holds(arb(0.1), NOTHING)
        assert arc.bends() == 0


def test_tangents_are_those_all_along() -> None:
    """dt/dz of t = z^2 goes from -0.2 to 0.2: time does not increase all the way."""
    arc = Arc(Curve({(0, 1): 1, (2, 0): -1}), place(0, 0), place(1, 0), place(1, 0))
    assert arc.holds(arb(0.1), NOTHING)
    slope = arc.tangents()[-1]
    assert slope.contains(0.2)
    assert slope.contains(-0.2)


def test_a_pose_is_proved_where_it_is_alone() -> None:
    for coefficients, t in ((CROSSING, 0.0), ({(2, 0): 1, (0, 1): -1}, 0.0)):
        assert at_time(Curve(coefficients), place(0, t)) is None
    found = at_time(Curve({(2, 0): 1, (0, 1): -1}), place(0.26, 0.0625))
    assert found is not None
    assert found[0].contains(0.25)


class Zero:
    """Seventeen equations: a polynomial in the first unknown, and linear ones."""

    def __init__(self, polynomial) -> None:
        self.polynomial = np.polynomial.Polynomial(polynomial)

    def at(self, x):
        def value(p):
            return sum((arb(c) * x[0] ** k for k, c in enumerate(p.coef.tolist())), arb(0))

        rows = [[arb(int(i == k)) for k in range(17)] for i in range(17)]
        rows[0][0] = value(self.polynomial.deriv())
        return [value(self.polynomial), *x[1:]], arb_mat(rows)

    def bends(self, x):
        return -1


def test_a_fold_is_proved_where_there_is_just_one() -> None:
    radius = 2.0**-80

    def proved(polynomial, x):
        return _krawczyk(Zero(polynomial), [arb(x), *[arb(0)] * 16])

    assert proved([-1, 0, 1], 1.0) is not None
    assert proved([-(2.0**-100), 0, 1], 2.0**-50) is not None
    # A double root near the box, and in it.
    for x in (0.3, 0.6, 0.9, 1.1, 1.2, 1.5):
        assert proved([0, 0, 1], x * radius) is None
    # Two roots in the box.
    for half in (0.1, 0.3, 0.49):
        assert proved([-((half * radius) ** 2), 0, 1], half * radius) is None
    # None in the box: the step leads out of it.
    for step in (1.1, 1.5, 3):
        assert proved([step * radius, 1], 0.0) is None


def fold_of(curve, z: float, t: float) -> Fold:
    zero = (*place(z, t)[:8], *[arb(int(k == 0)) for k in range(8)], arb(t))
    ball = tuple(a + arb(0, 2.0**-100) for a in zero)
    return Fold(t, t, np.eye(8)[0], np.eye(8)[0], -1, curve, ball)


def test_a_mode_beyond_another_fold_is_on_no_side() -> None:
    """t = 3 c z - z^3 has folds at z = c^(1/2), a maximum, and at -c^(1/2)."""
    c = 0.01
    curve = Curve({(0, 1): 1, (1, 0): -3 * c, (3, 0): 1})
    fold = fold_of(curve, 0.1, 2 * c * 0.1)
    for z, side in ((0.14, 1), (0.06, -1), (0.09, -1), (-0.11, 0), (-0.14, 0), (-0.3, 0)):
        t = 3 * c * z - z**3
        assert _Turn(fold, place(z, t)).side(place(z, t)) == side
    turn = _Turn(fold, place(0.11, 3 * c * 0.11 - 0.11**3))
    assert turn.side(place(0.105, 3 * c * 0.105 - 0.105**3)) == 1
    assert turn.side(place(0.105, 1.0)) == 0
    assert turn.side(place(0.3, 3 * c * 0.3 - 0.3**3)) == 0
    # The other place may be on either side.
    near = [arb(0.1, 0.01), *[arb(0)] * 7, arb(0.002, 1e-4)]
    assert _Turn(fold, near).side(near) == 0


def test_folds_are_the_same_if_times_and_points_are() -> None:
    def seen(low, high, *point):
        return SimpleNamespace(low=low, high=high, point=np.array([*point, 0, 0]))

    assert _same(seen(0.1, 0.2, 1, 0), seen(0.2, 0.3, 1, 0))
    assert _same(seen(0.1, 0.2, 1, 0), seen(0.2, 0.3, -2, 0))
    assert not _same(seen(0.1, 0.2, 1, 0), seen(0.21, 0.3, 1, 0))
    assert not _same(seen(0.1, 0.2, 1, 0), seen(0.1, 0.2, 1, 1e-5))


@pytest.mark.parametrize("kinds", ["DPP DPL DPP DLL AHL ALL", "DPH DHP DPP DLP AHH ALH"])
def test_values_on_the_way_are_within_the_bounds_of_the_kernel(kinds) -> None:
    """Largest c, and the norms of A - c N for all c, between rows whose signs differ, too."""
    rng = np.random.default_rng(1)
    instance = random_instance(parse_type(kinds), rng)[0]
    platform = MovingPlatform(instance)
    values = platform.internal(rng.normal(size=(3, 4, 6)) * [1, 1, 1, 1, 60, 60])
    low, high = platform._bounds(values)
    equations = moving_equations(instance)
    norms = equations.spectral_between(low, high)
    turning = np.diag([2.0] * 4 + [0.0] * 4)
    for part in np.linspace(0, 1, 21):
        between = values[:, :-1] + part * np.diff(values, axis=1)
        c = platform.coefficients(between).reshape(-1, 6)
        assert (low <= c).all()
        assert (c <= high).all()
        for row in c:
            moved = equations.hessians[:, 0] - row[:, None, None] * turning
            assert (np.linalg.norm(moved, ord=2, axis=(1, 2)) <= norms).all()
