"""The proved step of a controller against what controllers run, on machines of data/platforms.

    python -m benchmarks.controllers [--walks 40] [--costs]

There are four peers. Newton's method until it converges is used by LinuxCNC's genhexkins and many
others. Newton's method with three steps a cycle is used by Reachy Mini's own library, which is a
peer, too (``pip install reachy-mini-rust-kinematics``). The method of Nelder and Mead (SciPy) on
the sum of squared residuals is used by one telescope. All walk through the same values, half of the
walks about the pose of the machine at rest, half into a fold. The reference are the steps that the
program of `gsp export --to c` has proved. Printed are lines of the table in docs/controller.md. A
line has four numbers. The first counts the proved steps that the peer missed by more than a
millionth of the size, the second the walks in which it ended in another mode (or gave up). The
third counts the refusals of the program at which the peer returned a pose without a warning. The
fourth is the time of a step, calls from Python included. With ``--costs``: what one proved step and
Newton's method until it converges cost, both in C and in turns, for steps of some sizes from poses
about home.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import as_array
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.motion import measure
from gspcli.motion.following.follower import platform_numbers
from tests.support.controllers.compiled import CompiledController, Walks, poses_of
from tests.support.controllers.walks import platform, walk_values

Array = NDArray[np.float64]
#: A step of a peer: the pose before and the values after give the pose, or None if it says so.
Step = Callable[[Array, Array], Array | None]
#: A pose is missed by more than this part of the size (or radians), another mode by this.
MISSED, ELSEWHERE = 1e-6, 1e-2
#: Sizes of steps whose cost is measured, in radians and parts of the size.
STEPS = (1e-5, 1e-4, 1e-3, 1e-2)
#: Every so manieth walk is enough of a slow peer.
SLOW = 10


@dataclass
class Count:
    """The results of a peer on walks; after each it continues from its own state."""

    walks: int = 0
    steps: int = 0
    missed: int = 0
    elsewhere: int = 0
    refusals: int = 0
    silent: int = 0
    seconds: float = 0.0

    def line(self, machine: str, peer: str) -> str:
        """Return the line of the table."""
        cells = (
            machine,
            peer,
            f"{self.missed} of {self.steps}",
            f"{self.elsewhere} of {self.walks}",
            f"{self.silent} of {self.refusals}",
            f"{1e6 * self.seconds / max(self.steps + self.refusals, 1):.3g} µs",
        )
        return f"| {' | '.join(cells)} |"


def newton(program: CompiledController, most: int, *, asks: bool) -> Step:
    """Return Newton's method with this many steps; does it ask whether it has converged?"""

    def step(pose: Array, values: Array) -> Array | None:
        both = np.stack([values, values])[None]
        found, status = program.newton(pose[None], both, most=most)
        return None if asks and status[0, 1] else found[0, 1]

    return step


def nelder_mead(instance: Instance, size: float) -> Step:
    """Return SciPy's method on the squares of what is missing of the values."""
    from scipy.optimize import minimize

    def step(pose: Array, values: Array) -> Array | None:
        R, T = rotation_from_quaternion(pose[3:]), pose[:3]

        def missing(x: Array) -> float:
            at = rotation_from_vector(x[:3]) @ R, T + size * x[3:]
            return float(np.sum(((measure(instance, *at) - values) / size) ** 2))

        options = {"xatol": 1e-10, "fatol": 1e-20, "maxiter": 2000, "maxfev": 4000}
        simplex = np.concatenate((np.zeros((1, 6)), 1e-2 * np.eye(6)))
        found = minimize(
            missing,
            np.zeros(6),
            method="Nelder-Mead",
            options=options | {"initial_simplex": simplex},
        )
        turned = rotation_from_vector(found.x[:3]) @ R
        return poses_of(turned, T + size * found.x[3:]) if found.success else None

    return step


def reachy(instance: Instance) -> Step:
    """Return the library of Reachy Mini, which takes three steps a cycle."""
    from reachy_mini_rust_kinematics import ReachyMiniRustKinematics

    rows = instance.constraints
    library = ReachyMiniRustKinematics(0.04, rows[0].value.value)
    for row in rows:
        crank = row.base.crank
        centre, axis = as_array(crank.centre), as_array(crank.axis)
        axis /= np.linalg.norm(axis)
        arm = row.base.point - centre
        arm /= np.linalg.norm(arm)
        motor = np.eye(4)
        motor[:3] = np.column_stack((arm, np.cross(axis, arm), axis, centre))
        library.add_branch(row.platform.point.tolist(), motor.tolist(), 1)

    def step(pose: Array, values: Array) -> Array | None:
        at = np.eye(4)
        at[:3, :3], at[:3, 3] = rotation_from_quaternion(pose[3:]), pose[:3]
        library.reset_forward_kinematics(at.tolist())
        for _ in range(3):
            found = np.array(library.forward_kinematics(np.radians(values).tolist()))
        return poses_of(found[:3, :3], found[:3, 3])

    return step


def count(step: Step, values: Array, truth: Walks, size: float) -> Count:
    """Walk with a peer through the values that the program has walked through."""
    total = Count(walks=len(values))
    for walk, status in enumerate(truth.status):
        pose: Array | None = truth.poses[walk, 0]
        for row in range(1, len(status)):
            if status[row] < 0 or pose is None:
                break
            begun = time.process_time()
            pose = step(pose, values[walk, row])
            total.seconds += time.process_time() - begun
            if status[row]:
                total.refusals += 1
                total.silent += int(pose is not None)
                break
            total.steps += 1
            off = np.inf if pose is None else _apart(pose, truth.poses[walk, row], size)
            total.missed += int(off > MISSED)
            if off > ELSEWHERE:
                total.elsewhere += 1
                break
    return total


def _apart(a: Array, b: Array, size: float) -> float:
    turned = np.abs(rotation_from_quaternion(a[3:]) - rotation_from_quaternion(b[3:])).max()
    return float(max(turned, np.linalg.norm(a[:3] - b[:3]) / size))


def without_ranges(instance: Instance) -> Instance:
    """Return a machine whose values have no limits."""
    free = tuple(replace(row, limits=None) for row in instance.constraints)
    return replace(instance, constraints=free)


def costs(name: str) -> str:
    """Return the line of a machine: microseconds of Newton's method and of a proved step."""
    rng = np.random.default_rng(SEED)
    instance, (R, T) = platform(name, rng, home=HOMES[name])
    instance = without_ranges(instance)
    size = float(platform_numbers(instance).reach)
    with tempfile.TemporaryDirectory() as folder:
        program = CompiledController(instance, Path(folder))
    R = rotation_from_vector(0.1 * rng.normal(size=(200, 3))) @ R
    T = T + 0.1 * size * rng.normal(size=(200, 3))
    poses = poses_of(R, T)
    start, _ = program.inverse(poses)
    cells = [name]
    for step in STEPS:
        d = rng.normal(size=(200, 6))
        d *= step / np.linalg.norm(d, axis=1)[:, None]
        goal, _ = program.inverse(poses_of(rotation_from_vector(d[:, :3]) @ R, T + size * d[:, 3:]))
        walks = program.follow(poses, np.stack([start, goal], axis=1))
        one = walks.reports[:, 1, 3] == 1
        newton, proved = 1e6 * program.times(poses[one], start[one], goal[one])
        cells.append(f"{proved:.1f} / {newton:.1f} = {proved / newton:.1f}")
    return f"| {' | '.join(cells)} |"


def main() -> int:
    """Print the lines of the table."""
    line = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    line.add_argument("--walks", type=int, default=40)
    line.add_argument("--pace", type=int, default=5, help="how many steps of a walk are one here")
    line.add_argument("--costs", action="store_true", help="what one step costs, in its place")
    arguments = line.parse_args()
    if arguments.costs:
        print(*map(costs, ("nano-hexapod", "linuxcnc-hexapod", "rubin-camera")), sep="\n")
        return 0
    for name, peers in MACHINES.items():
        rng = np.random.default_rng(SEED)
        instance, (R, T) = platform(name, rng, home=HOMES[name])
        instance = without_ranges(instance)
        size = float(platform_numbers(instance).reach)
        with tempfile.TemporaryDirectory() as folder:
            program = CompiledController(instance, Path(folder))
        values, start = walk_values(instance, program, R, T, arguments.walks, rng)
        values = np.ascontiguousarray(values[:, :: arguments.pace])
        truth = program.follow(start, values)
        for peer, make in peers.items():
            try:
                step = make(instance, program, size)
            except ImportError as error:
                print(f"{name}, {peer}: {error}", file=sys.stderr)
                continue
            few = slice(None, None, SLOW if peer == "Nelder-Mead" else 1)
            some = Walks(*(part[few] for part in vars(truth).values()))
            print(count(step, values[few], some, size).line(name, peer), flush=True)
    return 0


Make = Callable[[Instance, CompiledController, float], Step]
_NEWTON: dict[str, Make] = {
    "Newton's method": lambda _, program, __: newton(program, 100, asks=True),
    "three steps of Newton's": lambda _, program, __: newton(program, 3, asks=False),
}
MACHINES: dict[str, dict[str, Make]] = {
    "nano-hexapod": _NEWTON,
    "linuxcnc-hexapod": _NEWTON,
    "reachy-mini-head": {"Reachy Mini's library": lambda instance, _, __: reachy(instance)},
    "rubin-camera": {"Nelder-Mead": lambda instance, _, size: nelder_mead(instance, size)},
}
#: The poses of the machines at rest: their heights above the base in the frames of their files.
HOMES = {
    "nano-hexapod": 0.09,
    "linuxcnc-hexapod": 20.0,
    "reachy-mini-head": 0.177,
    "rubin-camera": 0.0,
}

if __name__ == "__main__":
    sys.exit(main())
