"""Quadratic forms on Study points that constraints are made of, with balls as coefficients.

Distances from points, planes and lines times N, in the forms of `study` (paper, Section 4).
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb

from gspcli.catalogue.kinds import Kind, Law
from gspcli.certification.equations import study
from gspcli.certification.numbers.balls import cross, dot, norm

#: A quadratic form: coefficients of the forms of `study`, by their position.
Form = dict[int, arb]


def scaled(form: Form, factor: arb) -> Form:
    """Return a multiple of a form."""
    return {index: coefficient * factor for index, coefficient in form.items()}


def rotation_form(left: Sequence[arb], right: Sequence[arb]) -> Form:
    """Return N ``left . R right``."""
    return {study.ROTATION[i][j]: left[i] * right[j] for i in range(3) for j in range(3)}


def square_distance(a: list[arb], b: list[arb], d: arb) -> Form:
    """Return N times ``|R a + T - b|^2 - d^2``, the paper's equation (6)."""
    form = scaled(rotation_form(b, a), arb(-2))
    form[study.NORM] = dot(a, a) + dot(b, b) - d * d
    form[study.RHO] = arb(1)
    for k in range(3):
        form[study.BODY[k]] = 2 * a[k]
        form[study.TRANSLATION[k]] = -2 * b[k]
    return form


def base_height(a: list[arb], b: list[arb], u: list[arb]) -> Form:
    """Return N times ``u . (R a + T - b)`` with u fixed in the base."""
    form = rotation_form(u, a)
    form[study.NORM] = -dot(u, b)
    for k in range(3):
        form[study.TRANSLATION[k]] = u[k]
    return form


def platform_height(a: list[arb], b: list[arb], u: list[arb]) -> Form:
    """Return N times ``R u . (R a + T - b)`` with u fixed in the platform."""
    form = scaled(rotation_form(b, u), arb(-1))
    form[study.NORM] = dot(u, a)
    for k in range(3):
        form[study.BODY[k]] = u[k]
    return form


def mutual_moment(a: list[arb], b: list[arb], u: list[arb], v: list[arb]) -> Form:
    """Return N times ``(R a + T - b) . (R u x v)``."""
    # It is v . R (a x u) + v . (T x R u) - (v x b) . R u.
    form = rotation_form(v, cross(a, u))
    for index, coefficient in rotation_form(cross(v, b), u).items():
        form[index] -= coefficient
    for i in range(3):
        for j in range(3):
            form[study.MOMENT[i][j]] = v[i] * u[j]
    return form


def heights(a: list[arb], b: list[arb], u: list[arb], v: list[arb]) -> list[Form]:
    """Return N times two coordinates across a line, whose squares add up to that of the distance.

    Their axes and the direction of the line are right-handed.

    Parameters
    ----------
    a, b
        The point, and a point of the line: that of the platform first.
    u, v
        The direction of the line if it is the platform's or the base's; empty for the other.
    """
    axis = u or v
    least = min(range(3), key=lambda k: abs(float(axis[k].mid())))
    across = cross(axis, [arb(int(k == least)) for k in range(3)])
    units = [[x / norm(w) for x in w] for w in (across, cross(axis, across))]
    return [platform_height(a, b, w) if u else base_height(a, b, w) for w in units]


def forms_of(
    kind: Kind, a: list[arb], b: list[arb], u: list[arb], v: list[arb], d: arb
) -> list[Form]:
    """Return the quadrics of a constraint without its value, one or two.

    For an angle it is the product of the directions, for a plane the height of the point. For two
    points it is the square of their distance. A point and a line have this square and the height
    along the line. Two lines have the mutual moment and the product of the directions.

    Parameters
    ----------
    kind
        Of the constraint.
    a, b
        A point of the platform and of the base primitive.
    u, v
        Their directions or normals; empty for points.
    d
        A distance whose square is subtracted from that of points; zero if the value is open.
    """
    if not kind.is_distance:
        return [rotation_form(v, u)]
    if kind.law is Law.MOMENT:
        return [mutual_moment(a, b, u, v), rotation_form(v, u)]
    if kind.law is Law.SQUARE and not (u or v):
        return [square_distance(a, b, d)]
    height = platform_height(a, b, u) if u else base_height(a, b, v)
    if kind.law is Law.SQUARE:
        return [square_distance(a, b, d), height]
    return [scaled(height, arb(-1)) if u else height]
