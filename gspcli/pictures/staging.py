"""From a result to a scene: its modes, its motions and tracks as series of poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Constraint
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.residuals import condition_numbers, sides_of
from gspcli.pictures.scene import DrawnConstraint, Scene, Series, Stroke
from gspcli.pictures.stage import Stage
from gspcli.solver.result import SolveResult

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses to show, before anything is drawn.

    Attributes
    ----------
    title, item, note
        As in `Series`.
    R, T
        Shapes (n, 3, 3) and (n, 3), real.
    facts
        Further numbers or words about each pose.
    parameter
        What moves the platform, its name and values; None for modes.
    conditions
        Condition numbers where they are known, shape (n,).
    """

    title: str
    item: str
    R: Array
    T: Array
    facts: Mapping[str, list[Any]] = field(default_factory=dict)
    parameter: tuple[str, Array] | None = None
    conditions: Array | None = None
    note: str = ""


#: So many of the motions that were found are shown; often they are parts of one.
_MOTIONS = 8


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
        What is said of the result; its account if empty.
    """
    instance, arrangement = result.instance, result.arrangement
    shown = [_modes(result, only)]
    if only is None:
        shown += [*_motions(result), *tracks]
    R = np.concatenate([poses.R for poses in shown])
    T = np.concatenate([poses.T for poses in shown])
    names = _names(instance.constraints)
    staged = Stage(arrangement, names, R, T)
    platform = staged.body("platform", [row.platform for row in instance.constraints])
    base = staged.body("base", [row.base for row in instance.constraints])
    strokes, labels = staged.drawn(platform, base)
    series, first = [], 0
    for poses in shown:
        chosen = slice(first, first + len(poses.R))
        series.append(_series(arrangement, poses, strokes, labels, chosen))
        first = chosen.stop
    units, kind = instance.units, instance.type
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
            DrawnConstraint(i + 1, row.kind, *names[i], row.value.value)
            for i, row in enumerate(instance.constraints)
        ),
        series=tuple(series),
    )


def best_mode(result: SolveResult) -> int:
    """Return the index of the mode that is most likely meant; 0 if there is none.

    It is the best conditioned one, and of several the highest.
    """
    count = result.counts.real
    # Rounded: those that differ by rounding errors are equal, and the first of them counts.
    heights = (result.T[:count, 2].real / result.arrangement.length).round(6)
    conditions = [float(f"{value:.6g}") for value in result.conditions[:count]]
    return min(range(count), key=lambda k: (conditions[k], -heights[k]), default=0)


def _modes(result: SolveResult, only: int | None) -> Poses:
    chosen = slice(result.counts.real) if only is None else slice(only, only + 1)
    real = result.solutions[chosen]
    facts: dict[str, list[Any]] = {"residual": [float(f"{s.residual:.1e}") for s in real]}
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
    real = [motion for motion in result.motions if motion.real][:_MOTIONS]
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


def _names(constraints: Sequence[Constraint]) -> list[tuple[str, str]]:
    """Return the names of both primitives; those without a name get letter and number."""
    return [
        (
            row.platform_name or f"{row.platform.primitive.value}{i}",
            row.base_name or f"{row.base.primitive.value.lower()}{i}",
        )
        for i, row in enumerate(constraints, start=1)
    ]


def _series(
    arrangement: Arrangement,
    poses: Poses,
    strokes: Sequence[tuple[Stroke, ...]],
    labels: Array,
    chosen: slice,
) -> Series:
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
    return Series(
        title=poses.title,
        item=poses.item,
        R=R,
        T=T,
        quaternions=quaternion_from_rotation(R),
        measured=values,
        conditions=conditions,
        strokes=tuple(
            tuple(Stroke(stroke.style, stroke.points[chosen]) for stroke in each)
            for each in strokes
        ),
        labels=labels[chosen],
        facts=facts,
        parameter=poses.parameter,
        note=poses.note,
    )
