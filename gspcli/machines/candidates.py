"""Points, lines and planes of a chain that can be primitives of a constraint."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.tolerances import MEASURED_PARALLEL_SINE
from gspcli.machines.graph import Part
from gspcli.machines.kinds import Primitives
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Primitives that agree to this share of the size are one.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class CandidatePrimitives:
    """Primitives of a chain in the configuration of the file, in the frame of the base.

    Attributes
    ----------
    centres
        Centres of balls and crossings of hinge axes: only these have distances of two points.
    points
        All points that can have a distance from a line or plane.
    lines
        The axes of hinges.
    directions
        Directions that can have angles: those of the lines.
    planes
        Normals, with any point: it is moved to where the distance is to be measured.
    """

    centres: Primitives
    points: Primitives
    lines: Primitives
    directions: Primitives
    planes: Primitives

    def pairs(self, kind: str) -> tuple[Primitives, Primitives]:
        """Return candidates for both primitives of a kind, platform's and base's, in one frame.

        The points of planes are not chosen yet.
        """
        sorts = {"P": self.points, "L": self.lines, "H": self.planes}
        if kind == "DPP":
            return self.centres, self.centres
        if kind == "ALL":
            return self.directions, self.directions
        return sorts[kind[1]], sorts[kind[2]]


def candidates(passive: list[Part], size: float, near: float) -> CandidatePrimitives:
    """Return the candidates of a chain.

    Parameters
    ----------
    passive
        Its parts that are not held, in the frame of the base.
    size
        The size of the chain.
    near
        Axes that pass each other at a smaller distance than this cross.
    """
    balls = [part.point for part in passive if part.letter == "S"]
    hinges = [part for part in passive if part.letter == "R"]
    slides = [part for part in passive if part.letter == "P"]
    same = _SAME * size
    centres = balls + [
        crossing
        for first, second in combinations(hinges, 2)
        if (crossing := _crossing(first, second, near)) is not None
    ]
    for hinge in hinges:
        centres += [hinge.point + hinge.axis * ((c - hinge.point) @ hinge.axis) for c in centres]
        centres = _different(centres, same)
    centres = _different(centres, same)
    further = [hinge.point for hinge in hinges]
    further += [hinge.point + size * hinge.axis for hinge in hinges]
    points = _different(centres + further + [slide.point for slide in slides], same)
    lines = [np.concatenate((_foot(hinge), hinge.axis)) for hinge in hinges]
    kept = _places(lines, same)
    normals = _normals(balls, hinges, slides) if passive else []
    normals = _different(normals, _SAME)
    directions = _different([hinge.axis for hinge in hinges], _SAME)
    return CandidatePrimitives(
        Primitives.of(centres),
        Primitives.of(points),
        Primitives.of([hinges[k].point for k in kept], [hinges[k].axis for k in kept]),
        Primitives.of([np.zeros(3)] * len(directions), directions),
        Primitives.of([np.zeros(3)] * len(normals), normals),
    )


def _normals(balls: list[Array], hinges: list[Part], slides: list[Part]) -> list[Array]:
    """Return normals of planes in which points may stay: of slides, of hinges and across them."""
    normals = [
        across / np.linalg.norm(across)
        for first, second in combinations(slides, 2)
        if np.linalg.norm(across := np.cross(first.axis, second.axis)) > MEASURED_PARALLEL_SINE
    ]
    normals += [hinge.axis for hinge in hinges]
    if len(balls) == 1 and not hinges and not slides:
        return list(np.eye(3))
    for part in [*hinges, *slides]:
        first = np.cross(part.axis, np.eye(3)[np.argmin(np.abs(part.axis))])
        first /= np.linalg.norm(first)
        normals += [first, np.cross(part.axis, first)]
    return normals


def _crossing(first: Part, second: Part, near: float) -> Array | None:
    """Return where two axes cross, if they do."""
    across = np.cross(first.axis, second.axis)
    length = float(np.linalg.norm(across))
    if length < MEASURED_PARALLEL_SINE:
        return None
    sides = np.array([first.axis, -second.axis, across]).T
    s, t, gap = np.linalg.solve(sides, second.point - first.point)
    if abs(gap) * length > near:
        return None
    middle: Array = (first.point + s * first.axis + second.point + t * second.axis) / 2
    return middle


def _foot(part: Part) -> Array:
    foot: Array = part.point - part.axis * (part.point @ part.axis)
    return foot


def _places(vectors: list[Array], same: float) -> list[int]:
    """Return the indices of the vectors that differ from all earlier ones."""
    kept: list[int] = []
    for k, vector in enumerate(vectors):
        if all(np.linalg.norm(vector - vectors[other]) > same for other in kept):
            kept.append(k)
    return kept


def _different(vectors: list[Array], same: float) -> list[Array]:
    return [vectors[k] for k in _places(vectors, same)]
