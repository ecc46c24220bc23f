"""Poses to show, and how they become a series of a scene: with bodies that stand, or that move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import BODIES, choose, moved
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.residuals import condition_numbers, sides_of
from gspcli.pictures.scene import DrawnBody, SceneSeries, Stroke
from gspcli.pictures.stage import Stage
from gspcli.records import dataclass

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses to show, before anything is drawn.

    Attributes
    ----------
    title, item, note
        As in `SceneSeries`.
    R, T
        Shapes (n, 3, 3) and (n, 3), real.
    facts
        Further numbers or words about each pose.
    parameter
        What moves the platform, its name and values; None for modes.
    conditions
        Condition numbers where they are known, shape (n,).
    coordinates, places
        Names of coordinates that move (`gspcli.geometry.coordinates`), c of them, and where they
        are at each pose, shape (n, c).
    """

    title: str
    item: str
    R: Array
    T: Array
    facts: Mapping[str, list[Any]] = field(default_factory=dict)
    parameter: tuple[str, Array] | None = None
    conditions: Array | None = None
    note: str = ""
    coordinates: tuple[str, ...] = ()
    places: Array = field(default_factory=lambda: np.zeros((0, 0)))


def names_of(constraints: Sequence[Constraint]) -> list[tuple[str, str]]:
    """Return the names of both primitives; those without a name get letter and number."""
    return [
        (
            row.platform_name or f"{row.platform.primitive.value}{i}",
            row.base_name or f"{row.base.primitive.value.lower()}{i}",
        )
        for i, row in enumerate(constraints, start=1)
    ]


def series_of(
    arrangement: Arrangement, poses: Poses, strokes: Sequence[tuple[Stroke, ...]], labels: Array
) -> SceneSeries:
    """Return poses as they are shown.

    Parameters
    ----------
    arrangement
        The platform.
    poses
        The poses.
    strokes, labels
        As in `SceneSeries`.
    """
    R, T = poses.R, poses.T
    values = np.asarray(measured(arrangement, R, T).real).copy()
    values[:, arrangement.distances] = np.abs(values[:, arrangement.distances])
    values[:, arrangement.angles] /= arrangement.in_radians
    facts = dict(poses.facts)
    if poses.parameter is not None and any(kind.has_sides for kind in arrangement.kinds):
        sides = sides_of(arrangement, R, T)
        facts["sides"] = [
            "".join({1: "+", -1: "−", 0: ""}[s] for s in row) for row in sides.tolist()
        ]
    conditions = poses.conditions
    if conditions is None:
        conditions = condition_numbers(arrangement, R, T)
    return SceneSeries(
        title=poses.title,
        item=poses.item,
        R=R,
        T=T,
        quaternions=quaternion_from_rotation(R),
        measured=values,
        conditions=conditions,
        strokes=tuple(strokes),
        labels=labels,
        facts=facts,
        parameter=poses.parameter,
        note=poses.note,
    )


def moving_series(instance: Instance, poses: Poses, size: float) -> SceneSeries:
    """Return poses at which primitives are elsewhere in their bodies; lines and planes as needed.

    Parameters
    ----------
    instance
        The platform as it is stated.
    poses
        The poses, with coordinates.
    size
        Of the scene.

    Raises
    ------
    ArgumentError
        If a coordinate is none of the instance.
    """
    chosen = choose(instance, poses.coordinates)
    names = names_of(instance.constraints)
    parts: list[SceneSeries] = []
    for k, place in enumerate(poses.places):
        there = moved(instance, chosen, place)
        arrangement = Arrangement.of(there)
        one = replace(
            poses,
            R=poses.R[k : k + 1],
            T=poses.T[k : k + 1],
            facts={},
            conditions=None if poses.conditions is None else poses.conditions[k : k + 1],
        )
        stage = Stage(arrangement, names, one.R, one.T, size)
        platform, base = (
            stage.body(name, [getattr(row, name) for row in there.constraints]) for name in BODIES
        )
        shown = series_of(arrangement, one, *stage.drawn(platform, base))
        parts.append(replace(shown, bodies={"platform": [platform], "base": [base]}))
    return _joined(poses, parts, {one.body for one in chosen})


def _joined(poses: Poses, parts: Sequence[SceneSeries], moving: set[str]) -> SceneSeries:
    """Return the series of single poses as one, with the bodies that move."""
    facts = {**poses.facts}
    if parts and "sides" in parts[0].facts:
        facts["sides"] = [part.facts["sides"][0] for part in parts]
    bodies: dict[str, list[DrawnBody]] = {
        name: [part.bodies[name][0] for part in parts] for name in sorted(moving)
    }
    every = zip(*(part.strokes for part in parts), strict=True)
    return replace(
        parts[0],
        R=poses.R,
        T=poses.T,
        quaternions=quaternion_from_rotation(poses.R),
        measured=np.concatenate([part.measured for part in parts]),
        conditions=np.concatenate([part.conditions for part in parts]),
        strokes=tuple(
            tuple(
                Stroke(same[0].style, np.concatenate([stroke.points for stroke in same]))
                for same in zip(*each, strict=True)
            )
            for each in every
        ),
        labels=np.concatenate([part.labels for part in parts]),
        facts=facts,
        bodies=bodies,
    )
