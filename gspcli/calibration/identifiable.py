"""Which numbers data determine: the null space of the derivatives, in words, and what to measure.

Along some directions of the parameters nothing that was measured changes, or less than is known
before. A basis of them in which each has a number that all others lack names the numbers. With an
unknown measuring device and target twelve directions only say where the frames are.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.fitting import Fit, reduced
from gspcli.calibration.measurements import Measurements, Noise, alike
from gspcli.calibration.parameters import Model
from gspcli.geometry.quaternions import rotation_from_vector, vector_from_rotation
from gspcli.records import dataclass
from gspcli.wording import counted, listed

Array = NDArray[np.float64]

#: A motion of a frame is unknown if it agrees with an unknown direction up to this: the first where
#: derivatives vanish, the second where noise hides it.
_EXACT, _HIDDEN = 1e-5, 0.1
#: A direction is described by at most this many numbers, those above a part of the largest, and at
#: most this many directions are.
_SHOWN, _PART, _MOST = 4, 0.2, 3
#: Random poses that show what a sort of measurements determines: how many, turned (radians) and
#: shifted (typical lengths) by how much.
_POSES, _TURN, _SHIFT = 60, 0.4, 0.3
#: Poses that differ by less than these (radians; of a typical length) do not differ.
_SAME_TURN, _SAME_PLACE = 0.01, 1e-3


@dataclass(frozen=True)
class Unknowns:
    """What data do not determine.

    Attributes
    ----------
    count
        Of how many independent directions.
    frames
        How many of these only say where the frames of base and platform are; with an unknown
        measuring device and target they are kept as stated.
    sentences
        Which the others are, in words.
    """

    count: int
    frames: int
    sentences: tuple[str, ...]

    @property
    def missing(self) -> int:
        """How many directions are unknown that should be known."""
        return self.count - self.frames


def identifiable(found: Fit, seen: Measurements) -> Unknowns:
    """Return the directions that the data of a fit do not determine."""
    model, rows = found.model, found.directions[~found.known]
    if not len(rows):
        return Unknowns(0, 0, ())
    rounding = found.singular[~found.known].max() <= 1e-9 * found.singular.max()
    limit = _EXACT if rounding else _HIDDEN
    left, frames = rows.copy(), 0
    for motion in _frame_motions(model):
        scaled = (motion / model.sizes)[model.free]
        direction = scaled / np.linalg.norm(scaled)
        part = left @ direction
        hidden = np.linalg.norm(direction - rows.T @ (rows @ direction)) <= limit
        if hidden and np.linalg.norm(part) > 0.1:
            frames += 1
            left = np.linalg.svd(part[None])[2][1:] @ left
    sentences = []
    if unread := _unread(seen):
        sentences.append(f"no row has a reading of {listed(map(str, unread), 'and')}")
    # With fewer numbers than are to be estimated any combination is unknown.
    enough = found.freedom + int(found.known.sum()) >= int(model.free.sum())
    if len(left) and enough:
        names = [name for name, free in zip(model.names, model.free, strict=True) if free]
        sentences += [_combination(row, names) for row in _sparse(left)[:_MOST]]
        if len(left) > _MOST:
            sentences.append(f"{len(left) - _MOST} more combinations of them")
    return Unknowns(len(rows), frames, tuple(sentences))


def _unread(seen: Measurements) -> list[int]:
    """Return the constraints, from 1, that have no reading in any row."""
    return (np.flatnonzero(~np.isfinite(seen.readings).any(axis=0)) + 1).tolist()


def _frame_motions(model: Model) -> Iterator[Array]:
    """Yield how all parameters change as a body moves with its device or target, each (p,)."""
    if not model.with_frames:
        return
    A, at = rotation_from_vector(model.frames[:3]), model.geometry + 12
    for axis in np.eye(3):
        for body in ("base", "platform"):
            for turning in (False, True):
                change = np.zeros(len(model.free))
                for block, span in model.spans():
                    if block.body == body:
                        shift = np.cross(axis, block.point) if turning else axis
                        turn = axis if turning else np.zeros(3)
                        parts = (block.shifts @ shift, block.tilts @ turn)
                        change[span][: len(block.shifts) + len(block.tilts)] = np.concatenate(parts)
                frames = change[at:]
                if body == "base":
                    # A body that moves by xi looks the same from a device moved by A xi A^-1.
                    turn, shift = (-A @ axis, np.zeros(3)) if turning else (np.zeros(3), -A @ axis)
                    frames[:3], frames[3:6] = _vector_rate(model.frames[:3], turn), shift
                else:
                    shift = np.cross(axis, model.frames[9:]) if turning else axis
                    turn = axis if turning else np.zeros(3)
                    frames[6:9], frames[9:] = _vector_rate(model.frames[6:9], turn), shift
                yield change


def _vector_rate(vector: Array, omega: Array) -> Array:
    """Return how a rotation vector changes when its rotation turns by omega from the left."""
    step = 1e-6
    ends = [
        vector_from_rotation(rotation_from_vector(s * step * omega) @ rotation_from_vector(vector))
        for s in (1, -1)
    ]
    rate: Array = (ends[0] - ends[1]) / (2 * step)
    return rate


def _sparse(rows: Array) -> Array:
    """Return rows that span the same space, each with a number that is zero in all other rows."""
    rows = rows.copy()
    for k in range(len(rows)):
        column = int(np.abs(rows[k:]).max(axis=0).argmax())
        best = k + int(np.abs(rows[k:, column]).argmax())
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, column], rows[k])
    return rows


def _combination(row: Array, names: list[str]) -> str:
    large = np.abs(row) > _PART * np.abs(row).max()
    shown: list[str] = [names[j] for j in np.argsort(-np.abs(row))[:_SHOWN].tolist() if large[j]]
    more = " among others" if int(large.sum()) > _SHOWN else ""
    if len(shown) == 1 and not more:
        return shown[0]
    return f"a combination of {listed(shown, 'and')}{more}"


def advice(found: Fit, seen: Measurements) -> str:
    """Return what to measure so that more is known."""
    model = found.model
    if unread := _unread(seen):
        return f"give readings of {listed(map(str, unread), 'and')}, or hold what only they use"
    turns = vector_from_rotation(found.R @ found.R[0].T)
    turned = np.linalg.svd(turns, compute_uv=False) > _SAME_TURN
    wanted, limit = int(model.free.sum()), ""
    if not model.drives and not model.with_frames:
        most = _rank_of_sort(found, seen, turning=bool(turned[0]))
        if most < wanted:
            limit = f"poses of this sort tell at most {most}, however many: "
    if turned.sum() < 2:
        return f"{limit}measure poses that turn the platform, about axes that differ"
    places = np.linalg.norm(found.T - found.T.mean(axis=0), axis=1).max(initial=0.0)
    if places < _SAME_PLACE * model.length:
        return f"{limit}measure poses that move the platform, along x, y and z"
    has_turns, has_places = (bool(np.isfinite(a).any()) for a in (seen.rotations, seen.positions))
    if limit:
        if seen.points and not any(name in seen.targets for name in seen.points):
            return f"{limit}say where points are on the platform (--target), or measure whole poses"
        if has_places and not has_turns:
            return f"{limit}measure rotations, too, or three points of the platform"
        what = "positions" if has_turns or len(seen.inclinations) else "whole poses"
        return f"{limit}measure {what} of the platform, too"
    rows = np.isfinite(found.residual).sum(axis=1)
    lacking = wanted - found.freedom - int(found.known.sum())
    if lacking > 0:
        each = max(int(rows.max(initial=7)) - 6, 1)
        return f"measure at least {counted(-(-lacking // each), 'more pose')}"
    return "measure poses farther apart, or more exactly; --plan N says which"


def _rank_of_sort(found: Fit, seen: Measurements, *, turning: bool) -> int:
    """Return how many numbers measurements of these sorts tell at many random poses, a rank."""
    model, random = found.model, np.random.default_rng(0)
    size = _TURN if turning else 0.0
    turns = rotation_from_vector(size * random.normal(size=(_POSES, 3)))
    T = found.T.mean(axis=0) + _SHIFT * model.length * random.uniform(-1, 1, (_POSES, 3))
    there = alike(seen, turns @ found.R[0], T, None)
    slopes = reduced(model, turns @ found.R[0], T, there, Noise.usual(model.length)).slopes
    singular = np.linalg.svd(slopes * model.sizes[model.free], compute_uv=False)
    return int((singular > _EXACT * singular.max(initial=0.0)).sum())
