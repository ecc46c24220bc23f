"""Compare clearances of machines with cranks and slides with random changes of their drives.

Within the change that is proved regular, every random change of all drives must lead to a pose with
the same sign of the Jacobian determinant. Within the change that is proved for working modes, no
gain may change its sign. Poses are followed by Newton's method in small steps, with equations of
their own (`tests.support.independent_machines`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gspcli.defaults import SEED
from gspcli.geometry.machine import Machine
from gspcli.motion.singularities.clearances import each_clearance, weights_of
from tests.support.independent_machines import Equations, PlaneGeometry, machines

#: Random changes of each machine, and the steps to each.
CHANGES, STEPS = 13_000, 6
#: A little more than the bound, since the last digits of the record are rounded.
_WITHIN = 0.9999


@dataclass(frozen=True)
class Row:
    """What is proved of one machine at home, what was found, and how many changes contradict."""

    machine: str
    lower: float
    working_modes: float
    fold_found: float
    dead_point_found: float
    changes: int
    wrong: int


def examine(name: str, count: int = CHANGES) -> Row:
    """Bound the clearance of a machine, and try random changes within the bounds."""
    machine = machines()[name]()
    drives = Machine.of(machine.instance)
    weights, _ = weights_of(drives)
    (found,) = each_clearance(drives, machine.R[None], machine.T[None])
    equations, geometry = Equations(machine), PlaneGeometry(machine)
    q0 = geometry.numbers(machine.R[None], machine.T[None])[0]
    wrong = 0
    for bound, gains in ((found.lower, False), (found.working_modes, True)):
        rng = np.random.default_rng((SEED, int(gains)))
        part = rng.uniform(-1, 1, (count // 2, 6))
        # Half of them in the corners of the box, where a singularity comes first.
        part[::2] = np.sign(part[::2])
        change = part * weights * bound * _WITHIN
        followed = equations.followed(machine.R, machine.T, q0, change, STEPS)
        good = followed.regular & followed.working_modes if gains else followed.regular
        wrong += int((~good).sum())
    lower, working_modes, fold, dead_point = (
        float(f"{number:.3g}")
        for number in (found.lower, found.working_modes, found.upper, found.dead_point)
    )
    return Row(name, lower, working_modes, fold, dead_point, count // 2 * 2, wrong)
