"""Random instances with short numbers and at least one real pose."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gspcli.catalogue.coincidence import Bond, over_constraint, parse_sharing
from gspcli.catalogue.kinds import Primitive
from gspcli.catalogue.names import find_alias, parse_type
from gspcli.catalogue.types import GspType
from gspcli.defaults import SEED
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Array, Constraint, Instance, Side, Units
from gspcli.geometry.measurement import condition_numbers, jacobian, measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, Vector
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector

_BOND = re.compile(r"[PLH]\d+[-^][plh]\d+")
#: A hidden pose with a greater condition number is too near a singular one: draw again.
MAX_CONDITION = 1e3
_ATTEMPTS = 1000
_NEWTON_STEPS = 8
#: Newton's steps must shrink to this; lengths and radians are of the order of one.
_CONVERGED = 1e-12


def new(
    pattern: GspType | Sequence[Bond] | str | int,
    *,
    decimals: int = 3,
    planar: bool = False,
    one_sided: bool = False,
    seed: int = SEED,
) -> Instance:
    """Return a random instance with at least one real pose.

    Parameters
    ----------
    pattern
        A type, its name or its number, all primitives distinct; or which constraints share which
        primitives, as bonds or as a text such as ``P1-p1 P1-p2 P2-p3 P2-p4 P3-p5 P3-p6``.
    decimals
        With how many decimals numbers are written.
    planar
        Whether the points of each body lie in one plane.
    one_sided
        Whether one side of each DPH and DHP is stated, not both.
    seed
        The same seed gives the same instance.

    Raises
    ------
    GspError
        If the pattern can never fix the platform, or no well-conditioned pose was found.
    """
    if isinstance(pattern, str | int):
        pattern = _named(str(pattern))
    rng = np.random.default_rng(seed)
    made, _ = random_instance(pattern, rng, digits=decimals, planar=planar, one_sided=one_sided)
    return made


def _named(text: str) -> GspType | Sequence[Bond]:
    """Return the type or the shared primitives that a text names."""
    alias = find_alias(text)
    if (alias and alias.pattern) or any(map(_BOND.fullmatch, text.split())):
        return parse_sharing(text).bonds
    return parse_type(text)


def random_instance(
    pattern: GspType | Sequence[Bond],
    rng: np.random.Generator,
    *,
    digits: int = 3,
    planar: bool = False,
    one_sided: bool = False,
) -> tuple[Instance, tuple[Array, Array]]:
    """Return a random instance and a real pose of it.

    Coordinates are between -1 and 1, angles in degrees; the values are those at a random pose,
    rounded. The rounded values have a real pose near it, because Newton's method finds it.

    Parameters
    ----------
    pattern
        A type, all primitives distinct, or the constraints between numbered primitives.
    rng
        The source of randomness.
    digits
        Decimals of every number.
    planar
        Whether the points of each body (also those on lines and planes) lie in its plane z = 0.
    one_sided
        Whether DPH and DHP distances ask for the side of the hidden pose, or for both.

    Returns
    -------
    instance, (R, T)
        The instance and the pose: its rotation, shape (3, 3), and translation, shape (3,).

    Raises
    ------
    GspError
        If the pattern can never fix the platform, or no well-conditioned pose was found.
    """
    bonds = _distinct(pattern) if isinstance(pattern, GspType) else list(pattern)
    proof = over_constraint(bonds)
    if proof is not None:
        raise GspError(f"no instance of this pattern can fix the platform: {proof.reason}")
    for _ in range(_ATTEMPTS):
        R = rotation_from_quaternion(rng.normal(size=4))
        T = rng.uniform(-1, 1, size=3)
        draft = _draft(bonds, rng, digits, planar)
        instance = _with_values_at(draft, R, T, digits, one_sided)
        pose = None if instance is None else _pose_near(instance, R, T)
        if instance is not None and pose is not None:
            return instance, pose
    raise GspError(f"no well-conditioned pose found in {_ATTEMPTS} attempts: use more digits")


def _distinct(gsp_type: GspType) -> list[Bond]:
    """Return the constraints of a type with all primitives distinct, numbered by sort."""
    bonds: list[Bond] = []
    for kind in gsp_type.kinds:
        platform = sum(bond.kind.platform is kind.platform for bond in bonds)
        base = sum(bond.kind.base is kind.base for bond in bonds)
        bonds.append(Bond(kind, platform + 1, base + 1))
    return bonds


def _draft(bonds: Sequence[Bond], rng: np.random.Generator, digits: int, planar: bool) -> Instance:
    """Return an instance with random primitives and zero values."""
    platform: dict[str, Geometry] = {}
    base: dict[str, Geometry] = {}
    for bond in bonds:
        for body, name, primitive in (
            (platform, bond.platform_name, bond.kind.platform),
            (base, bond.base_name, bond.kind.base),
        ):
            if name not in body:
                body[name] = _primitive(primitive, rng, digits, planar)
    constraints = tuple(
        Constraint(
            kind=bond.kind,
            platform=platform[bond.platform_name],
            base=base[bond.base_name],
            value=Number.of(0),
            platform_name=bond.platform_name,
            base_name=bond.base_name,
        )
        for bond in bonds
    )
    return Instance(constraints, Units("unit", AngleUnit.DEGREE))


def _primitive(
    primitive: Primitive, rng: np.random.Generator, digits: int, planar: bool
) -> Geometry:
    x, y, z = _vector(rng.uniform(-1, 1, size=3), digits)
    position = (x, y, Number.of(0) if planar else z)
    if primitive is Primitive.POINT:
        return Point(position)
    direction = rng.normal(size=3)
    # Of length one before rounding, so that no digits get it near zero.
    rounded = _vector(direction / np.linalg.norm(direction), digits)
    return Line(position, rounded) if primitive is Primitive.LINE else Plane(position, rounded)


def _rounded(value: float, digits: int) -> Number:
    return Number.of(f"{value:.{digits}f}")


def _vector(values: Array, digits: int) -> Vector:
    x, y, z = (_rounded(value, digits) for value in values)
    return (x, y, z)


def _with_values_at(
    draft: Instance, R: Array, T: Array, digits: int, one_sided: bool
) -> Instance | None:
    """Return the instance with its values at a pose, rounded; None if one of them is zero."""
    values = measured(Arrangement.of(draft), R, T)
    constraints = []
    for constraint, value in zip(draft.constraints, values, strict=True):
        side = Side.BOTH
        if constraint.kind.is_distance:
            if constraint.kind.has_sides and one_sided:
                side = Side.POSITIVE if value > 0 else Side.NEGATIVE
            number = _rounded(abs(value), digits)
        else:
            number = _rounded(value / draft.units.angle.in_radians, digits)
        if number.fraction == 0:
            return None
        constraints.append(replace(constraint, value=number, side=side))
    return replace(draft, constraints=tuple(constraints))


def _pose_near(instance: Instance, R: Array, T: Array) -> tuple[Array, Array] | None:
    """Return the pose of an instance that Newton's method finds from a near one, if it does."""
    arrangement = Arrangement.of(instance)
    # Signed distances keep the sign that they have at the given pose.
    targets = np.copysign(arrangement.targets, measured(arrangement, R, T))
    for _ in range(_NEWTON_STEPS):
        if not condition_numbers(arrangement, R, T) < MAX_CONDITION:
            return None
        error = targets - measured(arrangement, R, T)
        step = np.linalg.solve(jacobian(arrangement, R, T), error)
        R, T = rotation_from_vector(step[:3]) @ R, T + step[3:]
        if np.abs(step).max() < _CONVERGED:
            return R, T
    return None
