"""The numbers from which a page finds all poses again when values move.

They are the numbers of a geometry for the kernel of the page (viewer/module/). They contain the
coefficients of values in equations, solved systems with complex values from which paths start, the
equations of proofs, poses far away, and the numbers of the step of a controller. The page has no
other mathematics.
"""

from __future__ import annotations

import base64
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.certification.equations.local_frames import reach
from gspcli.certification.numbers.rounding import ROUNDING
from gspcli.certification.numbers.sines import SINE_ERROR, SineNumbers
from gspcli.certification.poses.many_values import COSINE_ERROR, ValueProofs
from gspcli.continuation.systems import DEGREE_IN_F
from gspcli.continuation.tracker_options import (
    CAREFUL,
    SHORT,
    SHORT_STEPS,
    VALUE_STEPS,
    TrackerOptions,
)
from gspcli.defaults import SEED, TOLERANCE
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.drive_numbers import driven_points
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.primitives import Line
from gspcli.geometry.ranges import value_range
from gspcli.geometry.readings import factors, offsets, readings_of
from gspcli.motion.following.platform_numbers import platform_numbers
from gspcli.motion.singularities.pose_clearances import Displacements
from gspcli.pictures.arms import drawn_drives
from gspcli.pictures.live_drives import LiveMotors, apart
from gspcli.pictures.live_home import live_home
from gspcli.resources import data_path
from gspcli.solver.problem import Problem
from gspcli.solver.starts.solved_starts import SolvedStarts
from gspcli.solver.starts.start import Start
from gspcli.solver.study_systems import coefficients_of

if TYPE_CHECKING:
    from gspcli.solver.result import SolveResult

Array = NDArray[np.float64]

#: This many sets of values within the ranges are what starts are made for.
_ROWS = 1024
#: Where a value has no range: this part of it to either side, of angles of the way to their ends.
_PART = 0.3
#: This many where motors move joints.
_FEW = 16
#: A page that says more needs a moment for each set of values.
_QUICK = 100


class _Numbers:
    """Doubles, one after the other."""

    def __init__(self) -> None:
        self._parts: list[Array] = []

    def put(self, *numbers: ArrayLike) -> None:
        """Append numbers; complex ones as two each."""
        for each in numbers:
            array = np.ascontiguousarray(each)
            if array.dtype.kind == "c":
                array = array.astype(np.complex128).view(np.float64)
            self._parts.append(array.astype(np.float64).ravel())

    def text(self) -> str:
        """Return them in base64, least significant bytes first."""
        return base64.b64encode(np.concatenate(self._parts).astype("<f8").tobytes()).decode()


def live_numbers(result: SolveResult) -> dict[str, Any]:
    """Return what a page needs to solve a platform again for other values.

    Parameters
    ----------
    result
        The platform, solved.

    Returns
    -------
    dict
        ``values`` of the file; the ``ranges`` of sliders (readings, distances to planes without
        sign); the ``limits`` of what values can be (None: no limit); ``kinds``; ``units``. The
        index of the ``home`` mode or None; the ``sides`` of values (1, -1, 0 for both; None without
        sides); whether a solve is ``quick``. The ``proof`` of the count or None and its
        ``reservation`` in words; the ``drives`` (`drawn_drives`); the ``ways`` home (`live_home`);
        the ``numbers``, doubles in base64. Where motors move joints, these are of the m motors
        (`LiveMotors.moved`).

    Raises
    ------
    GspError
        If there is no start from which all poses for other values are found.
    """
    given = result.instance
    motors = LiveMotors.of(given)
    instance = given if motors is None else motors.family
    rows, ranges = _rows(instance)
    problem = Problem(instance, seed=SEED, starts=SolvedStarts())
    corrected = rows * factors(instance) + offsets(instance, signed=False)
    if motors is not None:
        # Members among the sets of values do not help: their joints are elsewhere.
        corrected = corrected[:_FEW]
    if not problem.local_frames.is_none:
        raise _cannot("its frames are far away from its bodies")
    proofs = ValueProofs.of(instance, corrected)
    start = _start(problem, corrected)
    if proofs is None or start is None:
        count = problem.count_geometry()
        if count is not None and not count.solutions:
            raise _cannot("its geometry has poses for special values alone")
        raise _cannot("no start was found that leads to all its poses")
    if motors is not None and start.far is not None:
        raise _cannot("some of its poses are far away wherever its joints are")
    numbers = _Numbers()
    _put_values(numbers, instance, start, motors)
    if motors is None:
        _put_pools(numbers, start)
    else:
        numbers.put(0)
    _put_whole(numbers, start, motors)
    _put_proofs(numbers, instance, proofs, start)
    _put_far(numbers, start)
    controller = platform_numbers(given if motors is None else apart(given))
    numbers.put(controller.kind, controller.either, controller.doubles)
    arrangement = result.arrangement
    numbers.put(start.found, arrangement.platform_centre, arrangement.extent)
    _put_clearance(numbers, given)
    numbers.put(*([0] if motors is None else [1, *motors.numbers(proofs)]))
    found, proof = _said(problem, ranges), start.proof
    reservation = "" if proof is None else proof.reservation
    if motors is not None:
        found, proof = motors.moved(found, start)
        found["stated"] = _stated(result)
        if proof is not None and proof.error:
            reservation = f"{proof.reservation}, counted with its joints at random places"
    return {
        **found,
        "home": None if result.home is None else result.home.number - 1,
        "quick": start.found <= _QUICK,
        "proof": proof and proof.to_json(),
        "reservation": reservation,
        "drives": drawn_drives(given),
        "ways": live_home(result),
        "numbers": numbers.text(),
    }


def live_module() -> str:
    """Return the kernel of the page, compressed, in base64."""
    return base64.b64encode(data_path("live", "kernel.wasm.gz").read_bytes()).decode()


def _said(problem: Problem, ranges: list[list[float]]) -> dict[str, Any]:
    """Return the facts about the six values that a page shows."""
    instance, stated = problem.instance, problem.arrangement
    units, rows = instance.units, instance.constraints
    return {
        "values": readings_of(instance, _values(instance), signed=False).tolist(),
        "ranges": ranges,
        "limits": _limits(instance),
        "kinds": [row.kind.name for row in rows],
        "units": [units.length if row.kind.is_distance else units.angle.value for row in rows],
        "sides": [
            side.item() if kind.has_sides else None
            for kind, side in zip(stated.kinds, stated.signs, strict=True)
        ],
    }


def _stated(result: SolveResult) -> dict[str, int] | None:
    """Return how many poses there are where the file has the joints, if that is proved."""
    counts = result.counts
    if result.proof is None or result.verdict != "complete" or counts.certified < counts.found:
        return None
    return {"poses": counts.found, "real": counts.real}


def _cannot(why: str) -> GspError:
    return GspError(f"a page cannot solve this platform: {why}")


def _values(instance: Instance) -> Array:
    return np.array([row.value.value for row in instance.constraints])


def _rows(instance: Instance) -> tuple[Array, list[list[float]]]:
    """Return sets of readings within the ranges, the file's among them, and the ranges."""
    values = _values(instance)
    ends = np.array([_range(instance, i, x) for i, x in enumerate(values.tolist())]).T
    low, high = readings_of(instance, ends, signed=False)
    rng = np.random.default_rng(SEED)
    rows = low + (high - low) * rng.random((_ROWS, len(values)))
    rows[0] = readings_of(instance, values, signed=False)
    return rows, np.stack((low, high), axis=1).tolist()


def _range(instance: Instance, i: int, value: float) -> list[float]:
    """Return between which values a slider goes; a value of zero stays."""
    row = instance.constraints[i]
    if value == 0:
        return [0.0, 0.0]
    if row.limits is not None:
        low, high = sorted(limit.value for limit in row.limits)
        if row.kind.has_sides and low < 0:
            low, high = _PART * abs(value), max(-low, high, abs(value))
        return [min(low, value), max(high, value)]
    if row.kind.is_distance:
        return [value * (1 - _PART), value * (1 + _PART)]
    least, most = value_range(row.kind, instance.units.angle)
    return [value + _PART * (least - value), value + _PART * (most - value)]


def _limits(instance: Instance) -> list[list[float | None]]:
    """Return the least and the greatest value that a pose can have, of each constraint."""
    ends = np.array([value_range(row.kind, instance.units.angle) for row in instance.constraints])
    readings = readings_of(instance, ends.T, signed=False).T
    return [[x if math.isfinite(x) else None for x in pair] for pair in readings.tolist()]


def _start(problem: Problem, rows: Array) -> Start | None:
    from gspcli.solver.all_poses import all_poses
    from gspcli.solver.strategies.row_groups import common_start

    return common_start(problem.with_rows(rows), all_poses)


def _put_values(
    numbers: _Numbers, instance: Instance, start: Start, motors: LiveMotors | None
) -> None:
    scale, shift = factors(instance), offsets(instance, signed=False)
    if motors is not None:
        scale, shift = motors.corrections(scale, shift)
    for i, row in enumerate(instance.constraints):
        kind = row.kind
        square = kind.is_squared
        height = kind.is_distance and kind.has_sides
        law = kind.law
        numbers.put(kind.is_distance, square, height, law.is_cosine, law.sign, scale[i], shift[i])
    numbers.put(len(start.choices), start.choices, start.length)
    degrees = instance.units.angle is AngleUnit.DEGREE
    sine = SineNumbers.of(degrees=degrees)
    numbers.put(degrees, sine.quarter, sine.unit, len(sine.terms), sine.small, sine.terms)
    numbers.put(COSINE_ERROR, SINE_ERROR)


def _put_pools(numbers: _Numbers, start: Start) -> None:
    homotopy = start.homotopy
    if homotopy is None:
        numbers.put(0)
        return
    first = slice(1)
    stages: list[tuple[slice, TrackerOptions]] = [(start.near, VALUE_STEPS), (first, SHORT_STEPS)]
    has_h = len(homotopy.pivots) + len(homotopy.free) == 7
    numbers.put(len(stages), len(homotopy.free), has_h, homotopy.pivots, homotopy.free)
    numbers.put(homotopy.forms, homotopy.slopes, homotopy.combinations)
    numbers.put(start.reduced.shape[1], start.length)
    for each, options in stages:
        parameters = start.parameters[each]
        numbers.put(len(parameters), parameters, start.unit, start.reduced[each])
        numbers.put(options.predictor_tolerance, options.contraction, options.radius_fraction)
        numbers.put(options.min_step, options.max_steps)


def _put_whole(numbers: _Numbers, start: Start, motors: LiveMotors | None) -> None:
    inner = start.inner
    signs = np.where(start.given.values == 0, 0.0, 1.0)
    given = inner.kinds, inner.y, inner.x, inner.u, inner.v
    # Coefficients are polynomials of second degree in the value.
    structure, found = coefficients_of(*given, np.outer((1.0, 2.0, 3.0), signs))
    order = list(structure.order)
    systems = [x[:, order] for x in found]
    systems[:2] = [x * start.scale**DEGREE_IN_F for x in systems[:2]]
    one, two, three = np.concatenate([x.reshape(3, -1) for x in systems], axis=1)
    square = (one - 2 * two + three) / 2
    slope = two - one - 3 * square
    parts = np.stack((one - slope - square, slope, square))
    if motors is not None:
        terms = [x[:, order] for x in motors.terms(start)]
        moved = [
            np.broadcast_to(
                motors.drives.driven[order].reshape(-1, *(1,) * (x.ndim - 2)), x.shape
            ).reshape(3, -1)
            for x in terms
        ]
        own = np.concatenate([x.reshape(3, -1) for x in terms], axis=1)
        parts = np.where(np.concatenate(moved, axis=1), own, parts)
    system = start.system
    numbers.put(system.structure.is_product, order, *system.coefficients)
    numbers.put(len(start.points), start.points, *parts)
    numbers.put(start.length * float(start.scale))
    for options in (SHORT, CAREFUL):
        numbers.put(options.predictor_tolerance, options.contraction, options.arrival)
        numbers.put(options.radius_fraction, options.min_step, options.waypoint, options.nearest)
        numbers.put(options.max_steps, options.late_steps)


def _put_proofs(numbers: _Numbers, instance: Instance, proofs: ValueProofs, start: Start) -> None:
    given = start.given
    numbers.put(len(proofs.numbers[0]), *proofs.numbers, given.base_centre, given.platform_centre)
    numbers.put(proofs.scale, TOLERANCE, reach(instance))
    lines = [
        np.outer(row.base.unit, row.platform.unit)
        for row in instance.constraints
        if row.kind is DLL and isinstance(row.platform, Line) and isinstance(row.base, Line)
    ]
    numbers.put(len(lines), *lines, ROUNDING)


def _put_far(numbers: _Numbers, start: Start) -> None:
    far = start.far
    if far is None:
        numbers.put(0)
        return
    numbers.put(
        len(far.real), far.products, far.numbers, far.errors, far.real, far.values, far.powers
    )
    numbers.put(far.scale, TOLERANCE, len(far.starts), far.origin, far.starts)


def _put_clearance(numbers: _Numbers, instance: Instance) -> None:
    if any(one.body == BODIES[0] for row in instance.constraints for one in driven_points(row)):
        # The ellipsoid of the platform's points would move.
        numbers.put(0)
        return
    try:
        home = Displacements(instance, np.eye(3)[None], np.zeros((1, 3)))
    except ArgumentError:
        # Its points lie on a line.
        numbers.put(0)
        return
    given = home.arrangement
    order = (DPP, DPL, DLP, DPH, DHP, DLL)
    kinds = [order.index(kind) if kind in order else len(order) for kind in given.kinds]
    numbers.put(1, kinds, given.y, given.x, given.u, given.v)
    numbers.put(home.centre, home.axes[0], home.radii)
