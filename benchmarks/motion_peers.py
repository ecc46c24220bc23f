"""Forward kinematics of hexapods by other programs of Python: times, and jumps to other modes.

Each is asked for all poses of a trajectory, one after the other, as its users do: it begins at the
pose that it found last. What is not installed is left out (`pip install basic-robotics scipy`).
"""

from __future__ import annotations

import contextlib
import io
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from benchmarks.motion_trajectories import Moves
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_vector

Array = NDArray[np.float64]

#: A pose that is farther from the right one is not it; lengths are of order one.
RIGHT = 1e-3
#: A pose whose legs are longer or shorter by more is none of the platform.
SOLVED = 1e-4
#: Gives the pose (R, T) for six lengths.
Solver = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Asked:
    """What a peer answered on a trajectory.

    Attributes
    ----------
    name
        The program and its version.
    microseconds
        Of processor time a pose.
    other
        How many poses are ones of another mode.
    unsolved
        How many are none of the platform.
    """

    name: str
    microseconds: float
    other: int
    unsolved: int


def ask_all(moves: Moves) -> Iterator[Asked]:
    """Ask every peer that is installed for the poses of one trajectory of a 6-6 platform."""
    for package, start in (("basic-robotics", _basic_robotics), ("scipy", _scipy)):
        try:
            solver = start(moves.instance, moves.R[0, 0], moves.T[0, 0])
        except ImportError:
            continue
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            began = time.process_time()
            found = [solver(row) for row in moves.values[0, 1:]]
            took = time.process_time() - began
        R, T = (np.stack(part) for part in zip(*found, strict=True))
        first = moves.R[:, 0], moves.T[:, 0]
        R, T = np.concatenate((first[0], R)), np.concatenate((first[1], T))
        yield judged(f"{package} {version(package)}", moves, R, T, took)


def joints(instance: Instance) -> tuple[Array, Array]:
    """Return the points of the platform and of the base, shape (6, 3)."""
    rows = [(c.platform.position, c.base.position) for c in instance.constraints]
    platform, base = (np.array([[x.value for x in row[k]] for row in rows]) for k in (0, 1))
    return platform, base


def judged(name: str, moves: Moves, R: Array, T: Array, took: float) -> Asked:
    """Return how well a trajectory was followed; of its first row nothing is said.

    Parameters
    ----------
    name
        Of the program.
    moves
        One trajectory, of a 6-6 platform.
    R, T
        What was found, shapes (r, 3, 3) and (r, 3); not finite where nothing was.
    took
        Seconds of processor time.
    """
    platform, base = joints(moves.instance)
    legs = np.einsum("nij,kj->nki", R, platform) + T[:, None] - base
    off = np.abs(np.linalg.norm(legs, axis=2) - moves.values[0]).max(axis=1)
    # Where nothing was found the comparison is false.
    solved = (off < SOLVED)[1:]
    far = (np.abs(R - moves.R[0]).max(axis=(1, 2)) > RIGHT)[1:]
    far |= (np.abs(T - moves.T[0]).max(axis=1) > RIGHT)[1:]
    count = len(solved)
    return Asked(name, took / count * 1e6, int((far & solved).sum()), int((~solved).sum()))


def _basic_robotics(instance: Instance, R: Array, T: Array) -> Solver:
    """Newton's method from the last pose; where it fails, from other ones."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from basic_robotics.general import tm
        from basic_robotics.kinematics.sp_model import SP

        platform, base = joints(instance)
        start = np.eye(4)
        start[:3, :3], start[:3, 3] = R, T
        model = SP(base.T.copy(), platform.T.copy(), tm(), tm(start), 0.0, 10.0, 0.0, 0.0, "")
        lengths = np.linalg.norm(platform @ R.T + T - base, axis=1)
        model.FK(lengths, protect=True)

    def solve(lengths: Array) -> tuple[Array, Array]:
        pose = model.FK(lengths, protect=True)[0].gTM()
        return pose[:3, :3].copy(), pose[:3, 3].copy()

    return solve


def _scipy(instance: Instance, R: Array, T: Array) -> Solver:
    """Powell's hybrid method from the last pose: `scipy.optimize.fsolve` on the lengths."""
    from scipy.optimize import fsolve

    platform, base = joints(instance)
    last = [R, T]

    def solve(lengths: Array) -> tuple[Array, Array]:
        def excess(x: Array) -> Array:
            legs = platform @ (rotation_from_vector(x[:3]) @ last[0]).T + last[1] + x[3:] - base
            return np.asarray(np.linalg.norm(legs, axis=1) - lengths)

        x = fsolve(excess, np.zeros(6))
        last[:] = rotation_from_vector(x[:3]) @ last[0], last[1] + x[3:]
        return last[0], last[1]

    return solve
