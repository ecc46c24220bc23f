"""Compare what live pages find with what `gsp solve` finds.

The values of a machine, or its motors, move a little at a time within their ranges, now and then to
any place in them. At each state the kernel of live pages (in Node) is compared with
`gspcli.solve_batch` (with `gspcli.solve`, if motors move joints). They must agree in the number of
real poses and in the poses. A set that the page calls complete must be complete. Condition numbers
and clearances must be those of gsp, and the poses must measure the values.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.motion.singularities.pose_clearances import (
    Displacements,
    Screws,
    pose_clearance,
    pose_clearances,
)
from gspcli.pictures.live_numbers import live_module, live_numbers
from tools.recording import ROOT

Array = NDArray[np.float64]
PROGRAM = ROOT / "viewer" / "states.mjs"
#: A drag moves values by this part of their ranges; one state in this many is anywhere in them.
STEP, JUMP = 0.02, 10
#: Poses are the same if they differ by less, as R and as T by the size; so do measured values.
SAME = 1e-10
#: Condition numbers, which grow as rounding errors do, by less of themselves times the number.
CONDITION = 1e-11
#: Clearances are sought to a hundredth. Two singular values of the screws are equal at home of
#: symmetric platforms, for instance. There the bound depends on the basis, which rounding chooses.
#: The page's bound is then a different proof; it must not exceed the distance of a singular pose.
NEAR = 0.02
#: Bounds by different formulas differ by less.
ALIKE = 0.05
APART = 1e-6


@dataclass
class Row:
    """The result of one machine.

    Attributes
    ----------
    platform
        Its name.
    states, complete, missed
        Sets of values, at how many the page says that it has all poses, proved, and at how many it
        says that some are missing although `gsp solve` proves them.
    real
        Real poses at all of them.
    verdicts, numbers, poses, conditions
        Numbers of states: at which the page wrongly says that it has all poses; at which the number
        of real poses differs; a pose; a condition number, a clearance or a measured value.
    refused
        Why the page is not live, if it is not.
    """

    platform: str
    states: int = 0
    complete: int = 0
    missed: int = 0
    real: int = 0
    verdicts: int = 0
    numbers: int = 0
    poses: int = 0
    conditions: int = 0
    refused: str = ""

    @property
    def task(self) -> str:
        """What was done."""
        return self.platform

    @property
    def done(self) -> bool:
        """Whether there is an answer."""
        return True

    def to_json(self) -> dict[str, Any]:
        """Return the row as plain data."""
        return asdict(self)


def dragged(ranges: Array, values: Array, states: int) -> Array:
    """Return sets of values as a user drags them, shape (states, m)."""
    rng = np.random.default_rng(SEED)
    low, high = ranges.T
    count = len(values)
    rows = np.empty((states, count))
    here = values
    for k in range(states):
        if k % JUMP == JUMP - 1:
            here = low + (high - low) * rng.random(count)
        else:
            change = rng.uniform(-1, 1, count) * (rng.random(count) < 0.5)
            here = here + STEP * (high - low) * change
        rows[k] = here = np.clip(here, low, high)
    rows[0] = values
    return rows


def solved_in_page(live: Mapping[str, Any], rows: Array) -> dict[str, Any]:
    """Return what the kernel of live pages finds for sets of values."""
    given = {"module": live_module(), "live": live, "states": rows.tolist()}
    run = subprocess.run(
        ["node", str(PROGRAM)], input=json.dumps(given), capture_output=True, text=True, check=True
    )
    found: dict[str, Any] = json.loads(run.stdout)
    return found


def compared(
    name: str,
    instance: Instance,
    states: int,
    run: Callable[[Mapping[str, Any], Array], dict[str, Any]] = solved_in_page,
) -> Row:
    """Return the results of one platform, with one way to run the kernel."""
    try:
        live = live_numbers(gspcli.solve(instance))
    except GspError as error:
        return Row(name, refused=str(error))
    rows = dragged(np.array(live["ranges"]), np.array(live["values"]), states)
    page = run(live, rows)
    is_moved = Machine.of(instance).moves
    solved = _solved_anew(instance, rows) if is_moved else _solved_together(instance, rows)
    row = Row(name, len(rows))
    compared_poses: list[tuple[int, Array, Array, Array]] = []
    for k, (found, other) in enumerate(zip(page["found"], solved, strict=True)):
        R, T = other.R, other.T
        here = np.array(found["poses"], float).reshape(-1, 12)
        row.complete += found["complete"]
        row.real += len(R)
        row.verdicts += bool(found["complete"]) and not other.is_proved
        row.missed += other.is_proved and not found["complete"]
        if len(here) != len(R):
            row.numbers += 1
        if len(here) != len(R) or not len(R):
            continue
        length = other.arrangement.length
        there = np.concatenate((R.reshape(-1, 9), T / length), axis=1)
        here[:, 9:] /= length
        order = np.abs(here[:, None] - there).max(axis=2).argmin(axis=1)
        off = np.abs(here - there[order]).max(initial=0)
        row.poses += bool(off > SAME) or len({*order.tolist()}) < len(order)
        compared_poses.append((k, R[order], T[order], other.conditions[order]))
    parts = [[each] for each in compared_poses] if is_moved else [compared_poses]
    row.conditions = sum(
        _others(solved[part[0][0]].instance, rows, page["measured"], part) for part in parts if part
    )
    return row


class _Solved(NamedTuple):
    """The real poses of a platform at one state."""

    instance: Instance
    arrangement: Arrangement
    R: Array
    T: Array
    conditions: Array
    is_proved: bool


def _solved_together(instance: Instance, rows: Array) -> list[_Solved]:
    """Return the poses for sets of values."""
    batch = gspcli.solve_batch(instance, rows)
    conditions = batch.conditions
    return [
        _Solved(
            instance,
            batch.arrangement,
            batch.R[k][chosen].real,
            batch.T[k][chosen].real,
            conditions[k][chosen],
            bool(batch.proved[k]),
        )
        for k, chosen in enumerate(batch.real)
    ]


def _solved_anew(instance: Instance, rows: Array) -> list[_Solved]:
    """Return the poses with the joints where motors bring them, each solved alone."""
    drives = Machine.of(instance)
    found = []
    for q in drives.from_readings(rows):
        there = drives.instance_at(q)
        result = gspcli.solve(there)
        R, T = result.R[result.real].real, result.T[result.real].real
        # Their unit of length is that of the joints where the file has them.
        arrangement = drives.arrangement(q)
        conditions = condition_numbers(arrangement, R, T)
        found.append(_Solved(there, arrangement, R, T, conditions, result.proof is not None))
    return found


def _others(
    instance: Instance,
    rows: Array,
    measured: list[Any],
    poses: list[tuple[int, Array, Array, Array]],
) -> int:
    """Return at how many states values, condition numbers or clearances of poses differ."""
    if not poses:
        return 0
    R, T = (np.concatenate([each[part] for each in poses]) for part in (1, 2))
    first = 0
    free, wrong = _clearances(instance, R, T), 0
    known = _have_one_basis(instance, R, T)
    for k, there, _, expected in poses:
        count = rows.shape[1]
        found = np.array(measured[k], float).reshape(-1, count + 2)
        here, free = free[: len(there)], free[len(there) :]
        has_one, known = known[: len(there)], known[len(there) :]
        expected = np.minimum(expected, 1e300)
        values = np.abs(found[:, :count] - rows[k]).max(axis=1)
        differ = ~(values <= SAME * np.abs(rows).max())
        differ |= np.abs(found[:, -2] - expected) > CONDITION * expected**2
        # Page and package bound a clearance by formulas of their own: both are below the truth.
        other_bound = ~has_one | (np.abs(found[:, -1] - here) > NEAR * here)
        differ |= has_one & (np.abs(found[:, -1] - here) > ALIKE * here)
        for other in np.flatnonzero(other_bound & (found[:, -1] > here)):
            nearest = pose_clearance(instance, R[first + other], T[first + other]).upper
            differ[other] |= found[other, -1] > nearest
        first += len(there)
        wrong += bool(differ.any())
    return wrong


def _clearances(instance: Instance, R: Array, T: Array) -> Array:
    """Return what pages show: zero where the points of the platform lie on a line."""
    try:
        return pose_clearances(instance, R, T)
    except ArgumentError:
        return np.zeros(len(R))


def _have_one_basis(instance: Instance, R: Array, T: Array) -> NDArray[np.bool_]:
    """Return at which poses the singular values of the screws are apart, shape (n,)."""
    try:
        screws = Screws(Displacements(instance, R, T)).matrices(np.zeros((len(R), 6)))
    except ArgumentError:
        return np.ones(len(R), np.bool_)
    values = np.linalg.svd(screws / np.linalg.norm(screws, axis=2, keepdims=True))[1]
    return np.asarray((np.diff(values, axis=1) < -APART * values[:, :1]).all(axis=1))
