"""Platforms whose solutions are infinitely many over the complex numbers and few over the reals.

Points at distance zero, a point on a line, and parallel directions are one equation each in the
paper (Section 4): a sum of squares, or the end of the range of a cosine. Over the complex numbers
it takes away one degree of freedom, over the reals two or three. So a platform with a ball in a
seat may have curves of complex solutions, and real poses on them that cannot move. Here such
constraints are stated by planes and right angles instead, six of these are solved, and the others
are checked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, islice

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, DHP, DLP, DPH, DPL, DPP, Kind
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES, GspType
from gspcli.certification import certify, refine
from gspcli.certification.counting import exact_count
from gspcli.certification.poses.exclusion import excluded
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Vector
from gspcli.geometry.residuals import relative_residuals
from gspcli.solver.results.pose_set import Motion, PoseSet

#: So many choices of six constraints are counted, of types with at most so many poses.
_CHOICES, _MOST_POSES = 40, 640
#: Decimals to which a pose is compared with the constraints that it was not made from.
_DIGITS = 50
#: Residuals, lengths by that of the platform, of what holds and what does not. Of multiple poses,
#: and of the distance of parallel lines, where its equation always holds, nothing else is known.
_HOLDS, _FAILS = 1e-9, 1e-4
#: Angles, in degrees, at which two directions are parallel.
_STRAIGHT = {ALL: ("0", "180"), ALH: ("90",), AHL: ("90",), AHH: ("0", "180")}
_RIGHT = {AngleUnit.DEGREE: Number.of(90), AngleUnit.RADIAN: Number.of("pi/2")}
_ZERO, _ONE = Number.of(0), Number.of(1)
_AXES: tuple[Vector, ...] = ((_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE))


def isolated_real_poses(
    instance: Instance, solve: Callable[[Instance], PoseSet]
) -> tuple[Motion, ...] | None:
    """Return the real poses of a platform, each a motion of dimension zero.

    It is proved that there are no others, and so that none can move. That all constraints hold at
    each of them is known to fifty decimals, or nine where poses meet and for the distance of
    parallel lines.

    Parameters
    ----------
    instance
        A platform with infinitely many solutions.
    solve
        How to solve the platforms that take its place.

    Returns
    -------
    tuple of Motion or None
        None if no constraint is several real ones, or if no six of these have finitely many
        solutions that can all be found.
    """
    unit = instance.units.angle
    rows = tuple(row for given in instance.constraints for row in _real_statement(given, unit))
    if len(rows) == CONSTRAINTS:
        return None
    # The sense of a direction is said by the angle itself.
    whole = replace(instance, constraints=(*rows, *instance.constraints))
    for chosen in islice(_choices(replace(instance, constraints=rows)), _CHOICES):
        count = exact_count(chosen)
        if count is not None and count.finite:
            poses = solve(chosen)
            return _common(whole, chosen, poses) if poses.proof is not None else None
    return None


def _choices(instance: Instance) -> Iterator[Instance]:
    """Yield six of the constraints at a time, those of types with few poses first."""
    choices: list[tuple[int, int, tuple[Constraint, ...]]] = []
    for rows in combinations(instance.constraints, CONSTRAINTS):
        if sum(not row.kind.is_distance for row in rows) <= MAX_ANGLES:
            counts = generic_counts(GspType.of(row.kind for row in rows))
            if counts.one_sided <= _MOST_POSES:
                choices.append((counts.one_sided, len(choices), rows))
    for _, _, rows in sorted(choices, key=lambda choice: choice[:2]):
        yield replace(instance, constraints=rows)


def _common(whole: Instance, chosen: Instance, poses: PoseSet) -> tuple[Motion, ...] | None:
    """Return the real poses at which all constraints hold, None if some are undecided."""
    real = poses.reordered(poses.real)
    arrangement = Arrangement.of(whole)
    sizes = relative_residuals(arrangement, real.R, real.T).max(axis=1, initial=0.0)
    kept = []
    certificates = certify(chosen, real.R, real.T)
    for k, certificate in enumerate(certificates):
        if _HOLDS < sizes[k] < _FAILS:
            return None
        if sizes[k] > _HOLDS:
            continue
        exact = refine(chosen, certificate, _DIGITS) if certificate.certified else None
        if exact is None or not excluded(whole, exact):
            kept.append(Motion(0, True, real.R[k : k + 1].real, real.T[k : k + 1].real))
    return tuple(kept)


def _real_statement(row: Constraint, unit: AngleUnit) -> list[Constraint]:
    """Return the equations of a constraint for real poses, except the sense of a direction."""
    zero = row.value.fraction == 0
    if row.kind is DPP and zero:
        return [_of_zero(row, DPH, axis) for axis in _AXES]
    if row.kind is DPL and zero:
        return [_of_zero(row, DPH, normal) for normal in _normals(_direction(row.base))]
    if row.kind is DLP and zero:
        return [_of_zero(row, DHP, normal) for normal in _normals(_direction(row.platform))]
    if not row.kind.is_distance and _exactly(row.value, unit) in _STRAIGHT[row.kind]:
        platform = Line(row.platform.position, _direction(row.platform))
        return [
            replace(row, kind=ALL, platform=platform, base=base, value=_RIGHT[unit])
            for base in (Line(row.base.position, n) for n in _normals(_direction(row.base)))
        ]
    return [row]


def _exactly(value: Number, unit: AngleUnit) -> str:
    """Return an angle of 0, 90 or 180 degrees in degrees, and others in any form."""
    text = str(value)
    return text if unit is AngleUnit.DEGREE else {"pi": "180", "pi / 2": "90"}.get(text, text)


def _of_zero(row: Constraint, kind: Kind, normal: Vector) -> Constraint:
    """Return the distance zero from a plane through the point or the line of a constraint."""
    if kind is DPH:
        return replace(row, kind=kind, base=Plane(row.base.position, normal))
    return replace(row, kind=kind, platform=Plane(row.platform.position, normal))


def _direction(geometry: Geometry) -> Vector:
    if isinstance(geometry, Line):
        return geometry.direction
    if isinstance(geometry, Plane):
        return geometry.normal
    message = "a point has no direction"
    raise TypeError(message)


def _normals(direction: Vector) -> list[Vector]:
    """Return two independent vectors normal to a direction: its products with two axes."""
    largest = max(range(3), key=lambda k: abs(direction[k].value))
    i, j = (largest + 1) % 3, (largest + 2) % 3
    normals = []
    for k, other in ((i, j), (j, i)):
        normal = [_ZERO] * 3
        normal[largest], normal[k] = _negated(direction[k]), direction[largest]
        normal[other] = _ZERO
        normals.append((normal[0], normal[1], normal[2]))
    return normals


def _negated(number: Number) -> Number:
    exact = number.fraction
    return Number("neg", (number,)) if exact is None else Number.of(-exact)
