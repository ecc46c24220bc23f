"""Time the nearest pose of a controller: `gspcli.Follower.nearest`.

    python -m benchmarks.nearest [--count 300]

Two kinds of requests are made to each machine: random poses about home, each from home, and a walk
that drifts, each from the one before. Printed are microseconds a request, the proof of the step
included: the median, the value that 95 of 100 stay below, and the most.
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np

import gspcli
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_vector
from tests.support.nearest import MACHINES, SHIFT, TURN, machine_of

#: Of the drift: what is kept of it from request to request, and what is added, in parts of TURN.
KEPT, ADDED = 0.99, 0.03
REPEATED = 3


def times_of(name: str, count: int) -> tuple[int, np.ndarray, np.ndarray]:
    """Return how many random requests are proved, and the seconds of random ones and of a walk."""
    machine = machine_of(name)
    controller = gspcli.Follower(machine.instance, machine.R, machine.T)._controller
    length = Arrangement.of(machine.instance).length
    draw = np.random.default_rng((SEED, *name.encode()))
    home = np.concatenate((machine.T, quaternion_from_rotation(machine.R)))

    def moved(turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
        R = rotation_from_vector(turn) @ machine.R
        return np.concatenate((machine.T + length * shift, quaternion_from_rotation(R)))

    proved, apart, along = 0, [], []
    for _ in range(count):
        goal = moved(TURN * draw.normal(size=3), SHIFT * draw.normal(size=3))
        seconds = []
        for _ in range(REPEATED):
            controller.start(home)
            begin = time.perf_counter()
            status = controller.nearest(goal)
            seconds.append(time.perf_counter() - begin)
        proved += status == 0
        apart.append(min(seconds))
    controller.start(home)
    drift = np.zeros(6)
    for _ in range(count):
        drift = KEPT * drift + ADDED * draw.normal(size=6)
        goal = moved(2 * drift[:3], drift[3:])
        begin = time.perf_counter()
        controller.nearest(goal)
        along.append(time.perf_counter() - begin)
    return proved, np.array(apart), np.array(along)


def main() -> int:
    """Print the times."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--count", type=int, default=300, help="requests of each kind")
    count = options.parse_args().count
    print(
        f"{'machine':24}{'proved':>8}{'median':>8}{'95 %':>8}{'most':>8}   drifting: median, 95 %"
    )
    for name in MACHINES:
        if name == "delta":
            continue  # a step has six values
        proved, apart, along = times_of(name, count)
        numbers = (np.median(apart), np.quantile(apart, 0.95), apart.max())
        line = "".join(f"{1e6 * x:8.0f}" for x in numbers)
        drifting = "".join(f"{1e6 * x:8.0f}" for x in (np.median(along), np.quantile(along, 0.95)))
        print(f"{name:24}{proved:8}{line}   {drifting}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
