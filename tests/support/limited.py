"""Platforms with ranges and cones for tests."""

from dataclasses import replace

import numpy as np

import gspcli
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import wrong_value
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Cone
from gspcli.geometry.random_instances import random_instance


def study(base_angle=30, platform_angle=60, legs=(80, 160)):
    """Return a published study: rings of 136 and 79 mm, cones about the legs 60 mm above home."""
    inner, outer = 45, 35
    upper = [s * inner / 2 + k for k in (0, 120, 240) for s in (1, -1)]
    upper = np.radians([upper[0], upper[3], upper[2], upper[5], upper[4], upper[1]])
    lower = np.radians([s * outer / 2 + k for k in (60, 180, 300) for s in (-1, 1)])
    top, bottom = (
        size * np.stack((np.cos(a), np.sin(a), 0 * a), axis=1)
        for size, a in ((79, upper), (136, lower))
    )
    legs_home = top - bottom + [0, 0, 60]
    return gspcli.instance(
        gspcli.distance(
            gspcli.Point(p.tolist(), Cone((-leg).tolist(), platform_angle)),
            gspcli.Point(b.tolist(), Cone(leg.tolist(), base_angle)),
            float(np.linalg.norm(leg)),
            range=legs,
        )
        for p, b, leg in zip(top, bottom, legs_home, strict=True)
    )


def one_leg(length=(1, 2), *, platform=(0, 0, 0), base=(0, 0, 0), **cones):
    """Return a platform of which only the first leg is limited; 'base_cone', 'platform_cone'."""
    rows = [
        gspcli.distance(
            gspcli.Point(list(platform), cones.get("platform_cone")),
            gspcli.Point(list(base), cones.get("base_cone")),
            length[1],
            range=length,
        )
    ]
    rows += [
        gspcli.distance(gspcli.Point([k, 1, k * k]), gspcli.Point([1, k, 0]), 3) for k in range(5)
    ]
    return gspcli.instance(rows)


def limited(name, seed, width=0.6, half_angle=50):
    """Return a random instance with ranges about the values of a pose, its legs in cones."""
    rng = np.random.default_rng(seed)
    instance, (R, T) = random_instance(gspcli.parse_type(name), rng, one_sided=seed % 2 == 0)
    r = Arrangement.of(instance).placed(R, T).r
    values = np.abs(measured(Arrangement.of(instance), R, T))
    rows = []
    for k, row in enumerate(instance.constraints):
        angle = not row.kind.is_distance
        middle = row.value.value if angle else values[k]
        size = width * (40 if angle else max(1.0, middle))
        limits = tuple(
            Number.of(f"{middle + sign * size * rng.uniform(0.5, 1):.3f}") for sign in (-1, 1)
        )
        ends = [_possible(row.kind, end, instance.units.angle) for end in limits]
        platform, base = row.platform, row.base
        if row.kind.name == "DPP":
            leg = r[k] + rng.normal(size=3) * 0.2 * np.linalg.norm(r[k])
            base = replace(base, cone=Cone(leg.round(3).tolist(), half_angle))
            platform = replace(platform, cone=Cone((-R.T @ leg).round(3).tolist(), half_angle + 50))
        rows.append(replace(row, platform=platform, base=base, limits=(ends[0], ends[1])))
    return replace(instance, constraints=tuple(rows)), R, T


def _possible(kind, number, unit):
    """Return a number, or the end of the range of its kind."""
    if not wrong_value(kind, number, unit):
        return number
    if kind.is_distance:
        return Number.of(0)
    low, high = (0, 180) if kind.platform is kind.base else (-90, 90)
    return Number.of(low if number.value < low else high)


def turned(instance, turn, shift):
    """Return an instance with its base moved: its poses are those of the other, moved."""
    turn, shift = np.asarray(turn, float), np.asarray(shift, float)
    moved = {}
    rows = []
    for row in instance.constraints:
        base = row.base
        if base not in moved:
            changes = {"position": (turn @ base.point + shift).tolist()}
            for key in ("direction", "normal"):
                if hasattr(base, key):
                    changes[key] = (turn @ base.unit).tolist()
            if getattr(base, "cone", None):
                changes["cone"] = Cone((turn @ base.cone.unit).tolist(), base.cone.half_angle)
            moved[base] = replace(base, **changes)
        rows.append(replace(row, base=moved[base]))
    return replace(instance, constraints=tuple(rows))
