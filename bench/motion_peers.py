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


def ask_all(instance: Instance, R: Array, T: Array, values: Array) -> Iterator[Asked]:
    """Ask every peer that is installed for the poses of a trajectory, but its first one.

    Parameters
    ----------
    instance
        A 6-6 platform.
    R, T, values
        The right poses and the lengths, shapes (n, 3, 3), (n, 3) and (n, 6).
    """
    for package, start in (("basic-robotics", _basic_robotics), ("scipy", _scipy)):
        try:
            solver = start(instance, R[0], T[0])
        except ImportError:
            continue
        yield _asked(f"{package} {version(package)}", solver, instance, R[1:], T[1:], values[1:])


def joints(instance: Instance) -> tuple[Array, Array]:
    """Return the points of the platform and of the base, shape (6, 3)."""
    rows = [(c.platform.position, c.base.position) for c in instance.constraints]
    platform, base = (np.array([[x.value for x in row[k]] for row in rows]) for k in (0, 1))
    return platform, base


def _asked(
    name: str, solver: Solver, instance: Instance, R: Array, T: Array, values: Array
) -> Asked:
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        began = time.process_time()
        found = [solver(row) for row in values]
        took = time.process_time() - began
    rotations, places = (np.stack(part) for part in zip(*found, strict=True))
    platform, base = joints(instance)
    legs = np.einsum("nij,kj->nki", rotations, platform) + places[:, None] - base
    solved = np.abs(np.linalg.norm(legs, axis=2) - values).max(axis=1) < SOLVED
    far = np.abs(rotations - R).max(axis=(1, 2)) > RIGHT
    far |= np.abs(places - T).max(axis=1) > RIGHT
    return Asked(name, took / len(values) * 1e6, int((far & solved).sum()), int((~solved).sum()))


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
