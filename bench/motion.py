"""Speed of what moves, on one core: `OPENBLAS_NUM_THREADS=1 python -m bench.motion`."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from gspcli.catalogue.parsing import parse_type
from gspcli.catalogue.types import GspType, all_types
from gspcli.geometry.instance import Instance
from gspcli.geometry.poses import rotation_from_quaternion
from gspcli.motion import measure
from gspcli.solver.generate import random_instance

SEED = 2003
POSES = 100_000


def seconds(run: Callable[[], object], *, repeat: int = 5) -> float:
    """Return the least processor time of some runs."""
    times = []
    for _ in range(repeat):
        began = time.process_time()
        run()
        times.append(time.process_time() - began)
    return min(times)


def measured_a_second(gsp_type: GspType) -> float:
    """Return how many poses of a random platform of a type are measured in a second."""
    rng = np.random.default_rng(SEED)
    instance: Instance = random_instance(gsp_type, rng)[0]
    R = rotation_from_quaternion(rng.normal(size=(POSES, 4)))
    T = rng.uniform(-1, 1, size=(POSES, 3))
    return POSES / seconds(lambda: measure(instance, R, T), repeat=3)


def main() -> None:
    """Print the figures and their bars."""
    hexapod = measured_a_second(parse_type("6PP"))
    print(f"measure, 6PP: {hexapod:,.0f} poses a second (bar 1,000,000)")
    speeds = {gsp_type: measured_a_second(gsp_type) for gsp_type in all_types()[::77]}
    slowest = min(speeds, key=speeds.__getitem__)
    print(
        f"measure, slowest of {len(speeds)} types, {slowest}: {speeds[slowest]:,.0f} poses a "
        "second (bar 300,000)"
    )


if __name__ == "__main__":
    main()
