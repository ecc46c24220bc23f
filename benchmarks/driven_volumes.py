"""Processor time of proved volumes of machines with motors, and of the same machines on legs.

    python -m benchmarks.driven_volumes [NAME ...] [--turns 3]

The machines are those of `tests.support.independent_machines`; the bounds of a volume
are 5 % apart. For a comparison the cranks and slides of each machine are replaced by legs from
where their points are stated. The ranges of the legs are what they measure at the poses that the
motors reach, so that both reach about as much. Both are measured in turns, and the least time
counts.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Point
from gspcli.motion import measure
from gspcli.motion.workspace.workspaces import workspace
from tests.support.independent_machines import Machine, PlaneGeometry, machines

#: The gap of the bounds of a volume, and what is free in a section.
GAP = 0.05
SECTIONS = {"positions": ("x", "y", "z"), "section": ("z", "rx", "ry")}
#: Poses that tell what legs measure.
_POSES = 3000

Array = NDArray[np.float64]


def main() -> int:
    """Measure, and print the ratios."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("names", nargs="*", metavar="NAME", help="machines (all)")
    options.add_argument("--turns", type=int, default=3)
    given = options.parse_args()
    known = machines()
    unknown = sorted({*given.names} - {*known})
    if unknown:
        options.error(f"found {', '.join(unknown)}, expected {', '.join(known)}")
    print("machine, section: s on motors, s on legs, ratio")
    for name in given.names or known:
        machine = known[name]()
        for section, free in SECTIONS.items():
            within = _within(machine, free)
            both = machine.instance, _on_legs(machine, free, within)
            times = np.array(
                [[_seconds(one, machine, free, within) for one in both] for _ in range(given.turns)]
            )
            motors, legs = times.min(axis=0)
            print(f"{name}, {section}: {motors:.2f} {legs:.2f} {motors / legs:.2f}", flush=True)
    return 0


def _within(machine: Machine, free: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    """Return the ends of the section, about home."""
    size, angle = machine.room[0] * 1.5, float(np.degrees(machine.room[1]) * 1.5)
    home = dict(zip("xyz", machine.T.tolist(), strict=True))
    return {
        name: (home[name] - size, home[name] + size) if name in home else (-angle, angle)
        for name in free
    }


def _seconds(
    instance: Instance,
    machine: Machine,
    free: tuple[str, ...],
    within: dict[str, tuple[float, float]],
) -> float:
    began = time.process_time()
    workspace(instance, machine.R, machine.T, free=free, within=within, tolerance=GAP)
    return time.process_time() - began


def _on_legs(
    machine: Machine, free: tuple[str, ...], within: dict[str, tuple[float, float]]
) -> Instance:
    """Return the machine on legs that reach about as much."""
    found = workspace(
        machine.instance, machine.R, machine.T, free=free, within=within, tolerance=0.5
    )
    ends = np.array([within[name] for name in free])
    points = np.random.default_rng(1).uniform(ends[:, 0], ends[:, 1], (_POSES, len(free)))
    parameters = np.tile(found.boxes.home, (_POSES, 1))
    columns = ["xyz".index(name[-1]) + 3 * name.startswith("r") for name in free]
    parameters[:, columns] = points * found.units
    R, T = found.boxes.poses(parameters)
    reached = PlaneGeometry(machine).reached(R, T)
    rows = [
        replace(row, platform=_bare(row.platform), base=_bare(row.base))
        for row in machine.instance.constraints
    ]
    still = replace(machine.instance, constraints=tuple(rows), home=None)
    values = measure(still, R[reached], T[reached])
    limits = zip(values.min(axis=0).tolist(), values.max(axis=0).tolist(), strict=True)
    legs = [
        replace(row, value=Number.of((low + high) / 2), limits=(Number.of(low), Number.of(high)))
        for row, (low, high) in zip(rows, limits, strict=True)
    ]
    return replace(still, constraints=tuple(legs))


def _bare(primitive: Geometry) -> Geometry:
    return Point(primitive.position) if isinstance(primitive, Point) else primitive


if __name__ == "__main__":
    sys.exit(main())
