"""Machines from files of other programs: modes are put into the joints of the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.errors import GspError
from gspcli.geometry.instance import METRES, Instance, Side
from gspcli.machines.graph import frame
from gspcli.machines.recognition import BodyChain, Machine, moved

Array = NDArray[np.float64]

#: Poses agree to this: translations in units of the largest, entries of rotations.
SAME = 1e-6
#: Loops are closed to this share of the size, and radians.
CLOSED = 1e-9


def poses(instance: Instance) -> tuple[Array, str]:
    """Return the real poses of an instance in metres, shape (n, 12), and the verdict."""
    result = gspcli.solve(instance)
    metre = METRES.get(instance.units.length, 1.0)
    R, T = result.R[result.real].real, result.T[result.real].real * metre
    return np.concatenate((R.reshape(-1, 9), T), axis=1), result.verdict


def on_the_side(instance: Instance, found: Instance, all_poses: Array) -> Array:
    """Return the poses at which points are on those sides of planes on which the import has them.

    Parameters
    ----------
    instance
        The original.
    found
        The import, in metres.
    all_poses
        Real poses of the original in metres, shape (n, 12).
    """
    if all(row.side is not Side.BOTH for row in instance.constraints if row.kind.has_sides):
        return all_poses
    R, T = all_poses[:, :9].reshape(-1, 3, 3), all_poses[:, 9:]
    measured = np.asarray(gspcli.measure(found, R, T))
    kept = np.ones(len(R), bool)
    for row, values in zip(found.constraints, measured.T, strict=True):
        if row.kind.has_sides:
            value = row.value.value * (-1.0 if row.side is Side.NEGATIVE else 1.0)
            kept &= np.abs(values - value) < 1e-5 * max(1.0, abs(value))
    return all_poses[kept]


def compared(before: Array, after: Array) -> tuple[int, int]:
    """Return how many poses are missing, and how many are too many."""
    if not len(before) or not len(after):
        return len(before), len(after)
    scale = max(1e-300, float(np.abs(before[:, 9:]).max()))
    weights = np.concatenate((np.ones(9), np.full(3, 1 / scale)))
    apart = np.abs((before[:, None] - after[None]) * weights).max(axis=2)
    return int((apart.min(axis=1) > SAME).sum()), int((apart.min(axis=0) > SAME).sum())


def gaps(machine: Machine, all_poses: Array, tries: int = 40) -> Array:
    """Return how far the chains of a machine stay from poses, shapes (n, 12) and (n,).

    The drives are held; Newton's method with damping moves all passive joints, from random starts.
    Lengths are shares of the size.
    """
    rng = np.random.default_rng(0)
    worst = np.zeros(len(all_poses))
    for k, row in enumerate(all_poses):
        goal = frame(row[:9].reshape(3, 3), row[9:])
        for chain in machine.structure.chains:
            free = [i for i, p in enumerate(chain.parts) if not p.held]
            best = np.inf
            for attempt in range(tries):
                best = min(best, _gap(chain, free, goal, machine.size, rng, attempt > 0))
                if best < CLOSED:
                    break
            worst[k] = max(worst[k], best)
    return worst


def _gap(
    chain: BodyChain,
    free: list[int],
    goal: Array,
    size: float,
    rng: np.random.Generator,
    random: bool,
) -> float:
    """Return how far a chain with the free joints moved stays from a frame, relative to a size."""
    wide = [3 if chain.parts[i].part.letter == "S" else 1 for i in free]
    x = rng.uniform(-2, 2, sum(wide)) if random else np.zeros(sum(wide))

    def residual(x: Array) -> Array:
        changes = [np.zeros(3) if p.part.letter == "S" else 0.0 for p in chain.parts]
        at = 0
        for i, width in zip(free, wide, strict=True):
            part = chain.parts[i].part
            change = x[at : at + width]
            changes[i] = (
                change if width == 3 else float(change[0]) * (size if part.letter == "P" else 1.0)
            )
            at += width
        X = moved(chain, changes)
        return np.concatenate(((X[:3, :3] - goal[:3, :3]).ravel(), (X[:3, 3] - goal[:3, 3]) / size))

    damping, r = 1e-2, residual(x)
    for _ in range(120):
        if np.abs(r).max() < 1e-14:
            break
        J = np.array(
            [(residual(x + 1e-7 * e) - residual(x - 1e-7 * e)) / 2e-7 for e in np.eye(len(x))]
        ).T
        step = -np.linalg.solve(J.T @ J + damping * np.eye(len(x)), J.T @ r)
        step *= min(1.0, 1.0 / max(1e-300, float(np.abs(step).max())))
        new = residual(x + step)
        if new @ new < r @ r:
            x, r, damping = x + step, new, max(damping / 4, 1e-15)
        else:
            damping = damping * 8
            if damping > 1e8:
                break
    return float(np.abs(r).max())


def files(paths: list[Path], meet: float) -> int:
    """Print what files are, their modes and the gaps of their joints; return how many are open."""
    from gspcli.machines.api import machine_of
    from gspcli.machines.recognition import recognized

    open_ = 0
    for path in paths:
        try:
            found = gspcli.import_machine(path, meet=meet)
        except GspError as error:
            print(f"{path.name}: refused: {error}", flush=True)
            continue
        graph = machine_of(path, stored=False)
        assert not isinstance(graph, Instance)
        machine = recognized(graph, meet=meet)
        result = gspcli.solve(found.instance)
        R, T = result.R[result.real].real, result.T[result.real].real
        off = gaps(machine, np.concatenate((R.reshape(-1, 9), T), axis=1))
        home = machine.pose
        away = [
            float(np.linalg.norm(t - home[:3, 3]) / machine.size + np.linalg.norm(r - home[:3, :3]))
            for r, t in zip(R, T, strict=True)
        ]
        open_ += int((off >= CLOSED).sum())
        stated = "no pose stated"
        if graph.has_home:
            stated = f"stated pose off by {min(away, default=np.nan):.1e}"
        print(
            f"{path.name}: {found.format}; {found.instance.type.id}; {result.counts.real} real of "
            f"{result.expected}; {stated}; loops of "
            f"{int((off < CLOSED).sum())} of {len(off)} closed, worst {max(off, default=0):.1e}",
            flush=True,
        )
    return open_
