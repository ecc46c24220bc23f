"""Check proved paths of machines with cranks and slides against samples.

- Segments: on each random straight way in position and angles that is proved, all samples are
  within the ranges. They have one sign of the determinant of the Jacobian matrix, and the same
  working modes. Half of the ways begin and end just within the ranges.
- Paths: along each path of drives that `gspcli.path` plans between two random poses, Newton's
  method in small steps finds poses with one sign of the determinant and with the same working
  modes. It ends at the goal.

The inverse kinematics and the equations are those of `tests.support.independent_machines`, which
share nothing with the proofs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.defaults import SEED
from gspcli.geometry import machine as geometry
from gspcli.motion.paths.ways import PoseWays
from tests.support.independent_machines import Equations, Machine, PlaneGeometry, machines

Array = NDArray[np.float64]

#: Random poses of which the first one that is reached is taken.
_TRIED = 64
#: How far the limits are looked for, in rooms of the machine.
_FAR = 16.0
#: Steps of Newton's method between two rows of a path.
_STEPS = 40
#: How far the poses that are followed to the goal may be from it, relative to the sizes.
_NEAR = 1e-8


@dataclass(frozen=True)
class Row:
    """What was found of one machine."""

    what: str
    machine: str
    tried: int
    proved: int
    wrong: int


class Draw:
    """Random poses of a machine within what it can reach."""

    def __init__(self, name: str, seed: int) -> None:
        machine: Machine = machines()[name]()
        self.machine = machine
        signs = geometry.Machine.of(machine.instance).at_home(machine.R, machine.T).signs
        self.ways = PoseWays(machine.instance, working_modes=signs)
        self.geometry = PlaneGeometry(machine)
        self.equations = Equations(machine)
        self.home = self.ways.parameters(machine.R, machine.T)
        self.room = np.repeat(machine.room, 3)
        self.draw = np.random.default_rng((SEED, seed, len(machine.name)))

    def pose(self, about: Array, size: float) -> Array:
        """Return parameters near others, at a pose that is reached, shape (6,)."""
        while True:
            tried: Array = about + self.draw.uniform(-1, 1, (_TRIED, 6)) * self.room * size
            reached = self.geometry.reached(*self.ways.poses(tried))
            if reached.any():
                return np.asarray(tried[int(reached.argmax())], float)

    def edge(self, about: Array) -> Array:
        """Return the parameters of a pose just within the limits, beyond a reached one, (6,)."""
        way = self.draw.normal(size=6) * self.room
        inside, outside = 0.0, 1.0
        while self.reached(about + outside * way) and outside < _FAR:
            inside, outside = outside, 2 * outside
        for _ in range(40):
            middle = (inside + outside) / 2
            if self.reached(about + middle * way):
                inside = middle
            else:
                outside = middle
        part = 1 - 10.0 ** -float(self.draw.uniform(1, 8))
        return np.asarray(about + inside * part * way, float)

    def reached(self, parameters: Array) -> bool:
        """Return whether a pose is reached."""
        R, T = self.ways.poses(parameters)
        return bool(self.geometry.reached(R[None], T[None])[0])

    def signs(self, R: Array, T: Array) -> Array:
        """Return the signs of det J and of the working modes at poses, shape (n, 7)."""
        _, J, rates = self.equations.jets(R, T, self.geometry.numbers(R, T))
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sign(np.column_stack((np.linalg.det(J), rates))), float)


def segments(name: str, count: int, samples: int) -> Row:
    """Return how many random ways are proved, and how many of them are wrong."""
    draw = Draw(name, 1)
    parts = np.linspace(0, 1, samples)[:, None]
    proved = wrong = 0
    for number in range(count):
        begin = draw.pose(draw.home, 10.0 ** draw.draw.uniform(-1, 0.5))
        end = draw.pose(begin, 10.0 ** draw.draw.uniform(-1.5, 0.5))
        if number % 2:
            begin, end = draw.edge(begin), draw.edge(begin)
        if not draw.ways.prove(begin, end).sign:
            continue
        proved += 1
        R, T = draw.ways.poses(begin + (end - begin) * parts)
        signs = draw.signs(R, T)
        good = draw.geometry.reached(R, T).all() and (signs == signs[0]).all() and signs[0].all()
        wrong += not good
    return Row("segments", name, count, proved, wrong)


def paths(name: str, count: int) -> Row:
    """Return how many paths of drives are planned, and how many of them are wrong."""
    draw = Draw(name, 2)
    instance = draw.machine.instance
    proved = wrong = 0
    for _ in range(count):
        ends = [draw.pose(draw.home, 0.7) for _ in range(2)]
        found = gspcli.path(instance, *map(draw.ways.poses, ends), along="values", time=5)
        if found.verdict != "proved":
            continue
        proved += 1
        assert found.drives is not None
        wrong += not is_kept(draw, found.R, found.T, found.drives)
    return Row("paths", name, count, proved, wrong)


def is_kept(draw: Draw, R: Array, T: Array, q: Array) -> bool:
    """Return whether regular poses with one working mode join the rows of a path of drives."""
    if not draw.geometry.reached(R, T).all():
        return False
    signs = draw.signs(R, T)
    if not (signs == signs[0]).all():
        return False
    for k in range(len(q) - 1):
        followed = draw.equations.followed(R[k], T[k], q[k], (q[k + 1] - q[k])[None], _STEPS)
        if not (followed.regular[0] and followed.working_modes[0]):
            return False
        away = np.abs(followed.T[0] - T[k + 1]).max() / draw.ways.sizes[0]
        if max(away, np.abs(followed.R[0] - R[k + 1]).max()) > _NEAR:
            return False
    return True
