"""From a result to a scene: its modes, its motions and tracks as series of poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.drive_numbers import arms_of
from gspcli.geometry.instance import Instance
from gspcli.geometry.printed_numbers import printed_residual
from gspcli.pictures.arms import arm_strokes, joined, with_drives
from gspcli.pictures.hulls import convex_hull
from gspcli.pictures.scene import DrawnConstraint, Scene, Stroke
from gspcli.pictures.shown_poses import Poses, moving_series, names_of, series_of
from gspcli.pictures.stage import Stage
from gspcli.solver.result import SolveResult

Array = NDArray[np.float64]

#: This many of the motions that were found are shown; often they are parts of one.
_MOTIONS = 8
#: Of more points only those farthest in this many directions are drawn: a hull of all takes long.
_CORNERS = 40


def drawn_diameters(instance: Instance) -> dict[int, float]:
    """Return the stated diameters of legs that are not zero, by the index of the constraint."""
    if instance.shapes is None:
        return {}
    legs = [k for k, row in enumerate(instance.constraints) if row.kind is DPP]
    stated = [one.value for one in instance.shapes.diameters]
    every = stated * len(legs) if len(stated) == 1 else stated
    return {k: diameter for k, diameter in zip(legs, every, strict=True) if diameter > 0}


def drawn_arms(instance: Instance) -> dict[int, float]:
    """Return the stated diameters of arms that are not zero, by the index of the constraint."""
    stated = {k: arm.diameter.value for k, arm in arms_of(instance).items()}
    return {k: diameter for k, diameter in stated.items() if diameter > 0}


def drawn_shells(instance: Instance) -> dict[str, tuple[Array, ...]]:
    """Return the faces of the stated outlines by the name of the body, in its frame."""
    found = {}
    for name in ("platform", "base"):
        stated = () if instance.shapes is None else getattr(instance.shapes, name)
        if stated:
            points = np.array([[x.value for x in point] for point in stated])
            faces = tuple(face for face in convex_hull(_corners(points)) if len(face) > 2)
            if faces:
                found[name] = faces
    return found


def _corners(points: Array) -> Array:
    """Return the points that are farthest in directions all around, if there are many."""
    if len(points) <= _CORNERS:
        return points
    # Directions on a spiral, evenly over the sphere.
    k = np.arange(_CORNERS)
    height, angle = 1 - (2 * k + 1) / _CORNERS, k * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    directions = np.stack((across * np.cos(angle), across * np.sin(angle), height), axis=1)
    return np.asarray(points[np.unique((points @ directions.T).argmax(axis=0))])


def scene_of(
    result: SolveResult,
    tracks: Sequence[Poses] = (),
    *,
    only: int | None = None,
    summary: str = "",
) -> Scene:
    """Return the scene of a result: its assembly modes, its motions, and tracks if given.

    Parameters
    ----------
    result
        What `gspcli.solver.solve` found.
    tracks
        Further poses of the same platform, such as those of a trajectory.
    only
        The index of one mode, if nothing else is to be shown: lines and planes are then drawn
        no larger than it needs.
    summary
        The text about the result; if empty, its account.
    """
    instance, arrangement = result.instance, result.arrangement
    shown = [_modes(result.drawn, only)]
    if only is None:
        shown += [*_motions(result), *(with_drives(instance, poses) for poses in tracks)]
    still = [poses for poses in shown if not poses.coordinates]
    R = np.concatenate([poses.R for poses in still])
    T = np.concatenate([poses.T for poses in still])
    names = names_of(instance.constraints)
    staged = Stage(arrangement, names, R, T)
    platform = staged.body("platform", [row.platform for row in instance.constraints])
    base = staged.body("base", [row.base for row in instance.constraints])
    strokes, labels = staged.drawn(platform, base)
    series, first = [], 0
    for poses in shown:
        arms = arm_strokes(instance, poses, staged.size)
        if poses.coordinates:
            moving = moving_series(instance, poses, staged.size)
            series.append(replace(moving, strokes=joined(moving.strokes, arms)))
            continue
        chosen = slice(first, first + len(poses.R))
        here = [tuple(Stroke(s.style, s.points[chosen]) for s in each) for each in strokes]
        here = [*joined(here, arms)]
        series.append(series_of(arrangement, poses, here, labels[chosen]))
        first = chosen.stop
    units, kind, diameters = instance.units, instance.type, drawn_diameters(instance)
    thick_arms = drawn_arms(instance)
    return Scene(
        title=instance.name or kind.id,
        type_id=f"{kind.id} (type {kind.number}, {kind.platform_class.id})",
        summary=summary or f"{result.poses.account_text}.",
        length_unit=units.length,
        angle_unit=units.angle.value,
        size=staged.size,
        platform=platform,
        base=base,
        bonds=tuple(
            DrawnConstraint(
                i + 1, row.kind, *names[i], row.value.value, diameters.get(i), thick_arms.get(i)
            )
            for i, row in enumerate(instance.constraints)
        ),
        series=tuple(series),
        shells=drawn_shells(instance),
    )


def first_mode(result: SolveResult) -> int:
    """Return the index of the mode that is shown first, which is home; 0 if there is none."""
    return 0 if result.home is None else result.home.number - 1


def _modes(result: SolveResult, only: int | None) -> Poses:
    chosen = slice(result.counts.real) if only is None else slice(only, only + 1)
    real = result.solutions[chosen]
    length = result.arrangement.length
    facts: dict[str, list[Any]] = {"residual": [printed_residual(s.residual, length) for s in real]}
    if any(solution.sides for solution in real):
        signs = {"positive": "+", "negative": "−"}
        facts["sides"] = ["".join(signs[side] for side in s.sides.values()) for s in real]
    if any(solution.multiplicity > 1 for solution in real):
        facts["multiplicity"] = [solution.multiplicity for solution in real]
    facts["certified"] = ["yes" if solution.certified else "no" for solution in real]
    return Poses(
        "Assembly modes",
        "mode",
        result.R[chosen].real,
        result.T[chosen].real,
        facts=facts,
        conditions=result.conditions[chosen],
    )


def _motions(result: SolveResult) -> list[Poses]:
    real = [motion for motion in result.motions if motion.real and motion.dimension][:_MOTIONS]
    return [
        Poses(
            "Self-motion" + (f" {number}" if len(real) > 1 else ""),
            "pose",
            motion.R.real,
            motion.T.real,
            parameter=("step", np.arange(len(motion.R), dtype=float)),
            conditions=np.full(len(motion.R), np.inf),
            note="A sample of the motion that was found: all values are kept along it.",
        )
        for number, motion in enumerate(real, start=1)
    ]
