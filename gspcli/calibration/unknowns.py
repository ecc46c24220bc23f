"""The directions that data do not determine, in words, and what to measure.

Along some directions of the parameters nothing that was measured changes. Each is compared with
motions that have names: a plane along its normal with the offset of its distance, both ends of a
leg together, a whole body with the measuring device. A direction without a name is described by its
largest numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.blocks import Block
from gspcli.calibration.exact_ranks import exact_rank
from gspcli.calibration.fitting import Fit, reduced
from gspcli.calibration.measurements import Measurements, Noise, alike
from gspcli.calibration.parameters import Model
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_vector, vector_from_rotation
from gspcli.records import dataclass
from gspcli.wording import counted, listed

Array = NDArray[np.float64]

_AXES = "xyz"
#: A motion with a name is unknown if it agrees with an unknown direction up to this: the first
#: where derivatives vanish, the second where noise hides it.
_EXACT, _HIDDEN = 1e-5, 0.1
#: This many numbers describe a direction without a name: those above a part of the largest.
_SHOWN, _PART = 4, 0.2
#: At most this many such directions are named.
_MOST = 3
#: Random poses that show what a sort of measurements determines: how many, turned (radians) and
#: shifted (typical lengths) by how much.
_POSES, _TURN, _SHIFT = 60, 0.4, 0.3
#: Poses that differ by less than these (radians; of a typical length) do not differ.
_SAME_TURN, _SAME_PLACE = 0.01, 1e-3


class ParameterMotion(NamedTuple):
    """A motion of parameters that has a name; alike ones are named in one sentence."""

    what: str
    how: str
    change: Array
    """Of all parameters, shape (p,)."""
    number: int | None = None
    """Of the constraint, from 1."""


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


def unknowns(found: Fit, seen: Measurements) -> Unknowns:
    """Return the directions that the data of a fit do not determine."""
    model, rows = found.model, found.directions[~found.known]
    if not len(rows):
        return Unknowns(0, 0, ())
    free = model.free
    rounding = found.singular[~found.known].max() <= 1e-9 * found.singular.max()
    limit = _EXACT if rounding else _HIDDEN
    left, frames, named = rows.copy(), 0, []
    for motion in (*_frame_motions(model), *_motions(model, found.R, found.T, seen)):
        scaled = motion.change / model.sizes
        size = float(np.linalg.norm(scaled))
        if not len(left) or not size or float(np.abs(scaled[~free]).max(initial=0)) > 1e-12 * size:
            continue
        direction = scaled[free] / size
        inside = rows.T @ (rows @ direction)
        part = left @ direction
        if np.linalg.norm(direction - inside) > limit or np.linalg.norm(part) < 0.1:
            continue
        if motion.what == _FRAMES:
            frames += 1
        else:
            named.append(motion)
        left = np.linalg.svd(part[None])[2][1:] @ left
    sentences = _sentences(named)
    if len(left) and not _too_few(found):
        names = [name for name, chosen in zip(model.names, free, strict=True) if chosen]
        sentences += [_numbers(row, names) for row in _sparse(left)[:_MOST]]
        if len(left) > _MOST:
            sentences.append(f"{len(left) - _MOST} more combinations of them")
    return Unknowns(len(rows), frames, tuple(sentences))


def _sentences(named: list[ParameterMotion]) -> list[str]:
    """Return motions in words, those of several constraints and along several axes together."""
    alike: dict[tuple[str, str], list[str]] = {}
    for (what, number), group in groupby(named, lambda motion: (motion.what, motion.number)):
        how = listed(dict.fromkeys(motion.how for motion in group), "and")
        alike.setdefault((what, how), []).append("" if number is None else str(number))
    sentences = []
    for (what, how), numbers in alike.items():
        whose = ""
        if numbers[0]:
            plural = "s" if len(numbers) > 1 else ""
            whose = f"constraint{plural} {listed(numbers, 'and')}: "
        sentences.append(f"{whose}{what} {how}".rstrip())
    return sentences


def _too_few(found: Fit) -> bool:
    """Whether there are fewer numbers than are to be estimated: any combination is unknown then."""
    return found.freedom + int(found.known.sum()) < int(found.model.free.sum())


_FRAMES = "frames"


def _frame_motions(model: Model) -> Iterator[ParameterMotion]:
    """Yield the motions of a whole body with device or target, which no measurement can tell."""
    if not model.with_frames:
        return
    A = rotation_from_vector(model.frames[:3])
    at = model.geometry + 12
    for axis in np.eye(3):
        for body in ("base", "platform"):
            for turning in (False, True):
                change = _body_motion(model, body, axis, turning=turning)
                frames = change[at:]
                if body == "base":
                    # A body that moves by xi looks the same from a device moved by A xi A^-1.
                    turn, shift = (-A @ axis, np.zeros(3)) if turning else (np.zeros(3), -A @ axis)
                    frames[:3] = _vector_rate(model.frames[:3], turn)
                    frames[3:6] = shift
                else:
                    shift = np.cross(axis, model.frames[9:]) if turning else axis
                    turn = axis if turning else np.zeros(3)
                    frames[6:9] = _vector_rate(model.frames[6:9], turn)
                    frames[9:] = shift
                yield ParameterMotion(_FRAMES, body, change)


def _vector_rate(vector: Array, omega: Array) -> Array:
    """Return how a rotation vector changes when its rotation turns by omega from the left."""
    step = 1e-6
    ends = [
        vector_from_rotation(rotation_from_vector(s * step * omega) @ rotation_from_vector(vector))
        for s in (1, -1)
    ]
    rate: Array = (ends[0] - ends[1]) / (2 * step)
    return rate


def _motions(model: Model, R: Array, T: Array, seen: Measurements) -> Iterator[ParameterMotion]:
    """Yield the other motions with names, the most special first."""
    yield from _unread(model, seen)
    yield from _planes(model)
    yield from _legs(model, R, T, seen)
    yield from _pairs(model)
    for body in ("base", "platform"):
        for how, turning in (("moved along", False), ("turned about", True)):
            for name, axis in zip(_AXES, np.eye(3), strict=True):
                change = _body_motion(model, body, axis, turning=turning)
                yield ParameterMotion(f"all of the {body} {how}", name, change)
    yield from _sizes(model, seen)


def _unread_rows(seen: Measurements) -> list[int]:
    """Return the constraints, from 0, that have no reading in any row."""
    return np.flatnonzero(~np.isfinite(seen.readings).any(axis=0)).tolist()


def _unread(model: Model, seen: Measurements) -> Iterator[ParameterMotion]:
    """Yield changes of what only constraints without readings use."""
    for k in _unread_rows(seen):
        own = np.zeros(len(model.free), bool)
        for block, span in model.spans():
            own[span] = block.rows == (k,)
        own[[model.geometry + k, model.geometry + 6 + k]] = True
        for parameter in np.flatnonzero(own):
            change = np.where(np.arange(len(own)) == parameter, 1.0, 0.0)
            yield ParameterMotion("no row has a reading", "", change, k + 1)


def _planes(model: Model) -> Iterator[ParameterMotion]:
    for block, span in model.spans():
        if block.sort != "plane" or not len(block.shifts):
            continue
        change = _in(model, span, block, block.unit)
        numbers = listed((str(k + 1) for k in block.rows), "and")
        # Signed distances become smaller, whichever body the plane is of.
        for k in block.rows:
            change[model.geometry + k] = -1.0 if model.kinds[k].has_sides else 0.0
        offsets = (
            "the offset of constraint" if len(block.rows) == 1 else "the offsets of constraints"
        )
        what = f"the {block.body}'s plane {block.name} along its normal, with {offsets}"
        yield ParameterMotion(what, numbers, change)


def _legs(model: Model, R: Array, T: Array, seen: Measurements) -> Iterator[ParameterMotion]:
    """Yield the ends of legs along them, with their offsets; and offsets with scales."""
    bodies = model.bodies(seen.drives)
    directions = bodies.placed(R, T).r
    directions = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    for k, kind in enumerate(model.kinds):
        if kind.name != "DPP":
            continue
        for body, axes in (("platform", directions[:, k] @ np.eye(3)), ("base", directions[:, k])):
            local = np.einsum("nba,nb->na", R, axes) if body == "platform" else axes
            mean = local.mean(axis=0)
            span, block = _of(model, k, body)
            change = _in(model, span, block, mean if body == "platform" else -mean)
            change[model.geometry + k] = 1.0
            yield ParameterMotion(f"{body} joint along the leg, with", "its offset", change, k + 1)


def _pairs(model: Model) -> Iterator[ParameterMotion]:
    """Yield the two primitives of a constraint shifted alike."""
    for k in range(len(model.kinds)):
        found = [_of(model, k, body) for body in ("platform", "base")]
        if any(len(block.rows) > 1 or not len(block.shifts) for _, block in found):
            continue
        for name, axis in zip(_AXES, np.eye(3), strict=True):
            change = sum(_in(model, span, block, axis) for span, block in found)
            yield ParameterMotion("both primitives together along", name, np.asarray(change), k + 1)


def _sizes(model: Model, seen: Measurements) -> Iterator[ParameterMotion]:
    """Yield the size of everything with the scales, and each scale with its offset."""
    change = np.zeros(len(model.free))
    for block, span in model.spans():
        change += _in(model, span, block, block.point)
        if block.is_drive:
            # Angles do not change; the readings of rails become longer with everything.
            change[span.stop - 1] = 1.0 if block.sort == "slide" else 0.0
    for k, kind in enumerate(model.kinds):
        change[model.geometry + 6 + k] = 1.0 if kind.is_distance else 0.0
    yield ParameterMotion("the size of everything with", "the scales", change)
    for k, readings in enumerate(seen.readings.T):
        read = readings[np.isfinite(readings)]
        if len(read):
            change = np.zeros(len(model.free))
            change[model.geometry + 6 + k], change[model.geometry + k] = 1.0, -read.mean()
            yield ParameterMotion("its scale with", "its offset", change, k + 1)


def _of(model: Model, k: int, body: str) -> tuple[slice, Block]:
    return next(
        (span, block)
        for block, span in model.spans()
        if block.body == body and k in block.rows and not block.is_drive
    )


def _in(model: Model, span: slice, block: Block, shift: Array, turn: Array | None = None) -> Array:
    """Return a small motion of one primitive as a change of all parameters."""
    change = np.zeros(len(model.free))
    part = change[span]
    part[: len(block.shifts)] = block.shifts @ shift
    if turn is not None:
        first = len(block.shifts)
        part[first : first + len(block.tilts)] = block.tilts @ turn
    return change


def _body_motion(model: Model, body: str, axis: Array, *, turning: bool) -> Array:
    change = np.zeros(len(model.free))
    for block, span in model.spans():
        if block.body == body:
            shift = np.cross(axis, block.point) if turning else axis
            change += _in(model, span, block, shift, axis if turning else None)
    return change


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


def _numbers(row: Array, names: list[str]) -> str:
    order = np.argsort(-np.abs(row))[:_SHOWN]
    shown = [names[j] for j in order.tolist() if abs(row[j]) > _PART * np.abs(row).max()]
    more = " among others" if int((np.abs(row) > _PART * np.abs(row).max()).sum()) > _SHOWN else ""
    return f"a combination of {listed(shown, 'and')}{more}"


def advice(instance: Instance, found: Fit, seen: Measurements) -> str:
    """Return what to measure so that more is known."""
    model = found.model
    if unread := [str(k + 1) for k in _unread_rows(seen)]:
        return f"give readings of {listed(unread, 'and')}, or hold what only they use"
    motion = _motion(found)
    measured = _measured(seen)
    most = None
    if not model.drives and not model.with_frames:
        if measured:
            most = exact_rank(instance, model, motion=motion, measured=measured)
        elif motion == "all":
            most = _rank_of_sort(found, seen)
    wanted = int(model.free.sum())
    limit = ""
    if most is not None and most < wanted:
        limit = f"poses of this sort tell at most {most}, however many: "
    if motion != "all":
        return f"{limit}measure poses that turn the platform, about axes that differ"
    places = np.linalg.norm(found.T - found.T.mean(axis=0), axis=1).max(initial=0.0)
    if places < _SAME_PLACE * model.length:
        return f"{limit}measure poses that move the platform, along x, y and z"
    if measured == "inclination":
        return f"{limit}measure positions of the platform, too"
    if measured == "position":
        return f"{limit}measure rotations, too, or three points of the platform"
    if most is not None and most < wanted:
        placed = [name for name in seen.points if name in seen.targets]
        if seen.points and not placed:
            return f"{limit}say where points are on the platform (--target), or measure whole poses"
        what = "positions" if np.isfinite(seen.rotations).any() else "whole poses"
        return f"{limit}measure {what} of the platform, too"
    rows = np.isfinite(found.residual).sum(axis=1)
    lacking = wanted - found.freedom - int(found.known.sum())
    if lacking > 0:
        each = max(int(rows.max(initial=7)) - 6, 1)
        return f"measure at least {counted(-(-lacking // each), 'more pose')}"
    return "measure poses farther apart, or more exactly; --plan N says which"


def _rank_of_sort(found: Fit, seen: Measurements) -> int:
    """Return how many numbers measurements of the sorts that were made tell at many random poses.

    A numerical rank, at poses far apart.
    """
    model, random = found.model, np.random.default_rng(0)
    turns = rotation_from_vector(_TURN * random.normal(size=(_POSES, 3)))
    T = found.T.mean(axis=0) + _SHIFT * model.length * random.uniform(-1, 1, (_POSES, 3))
    there = alike(seen, turns @ found.R[0], T, None)
    slopes = reduced(model, turns @ found.R[0], T, there, Noise.usual(model.length)).slopes
    singular = np.linalg.svd(slopes * model.sizes[model.free], compute_uv=False)
    return int((singular > _EXACT * singular.max(initial=0.0)).sum())


def _motion(found: Fit) -> Literal["all", "translations", "one axis"]:
    """Return how the poses differ."""
    turns = vector_from_rotation(found.R @ found.R[0].T)
    sizes = np.linalg.svd(turns, compute_uv=False)
    if sizes[0] < _SAME_TURN:
        return "translations"
    return "one axis" if len(sizes) < 2 or sizes[1] < _SAME_TURN else "all"


def _measured(seen: Measurements) -> Literal["pose", "position", "inclination"] | None:
    """Return what was measured of poses, if it is of one of the sorts of `exact_rank`."""
    turned, placed = (bool(np.isfinite(a).any()) for a in (seen.rotations, seen.positions))
    if seen.points or (len(seen.inclinations) and (turned or placed)):
        return None
    if turned and placed:
        return "pose"
    if placed:
        return "position"
    return "inclination" if len(seen.inclinations) else None
