"""Natural frequencies and mass matrices from what a program for trees of bodies says.

What a tree must give (`ClosedTree`, `PinocchioTree`): the mass matrix of a machine by the twist of
its platform, the rates of its drives, and what its drives hold at rest. No formula of
`gspcli.dynamics` is used for them.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from gspcli.dynamics import natural_modes
from gspcli.dynamics.actuation import Actuation
from gspcli.dynamics.mass_model import MassModel
from gspcli.dynamics.moving_bodies import equation_of_motion
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import METRES
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import rotation_from_vector
from tests.support.driven_machines import driven, rebased, some_pose, weighed

#: Central differences of the eighth order: weights of steps ahead, less those of steps back.
_WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
#: Their step, in radians and parts of the size: half and twice as much agree to 2e-10.
_STEP = 1e-3


def reference_squares(tree_at, R, T, size, metre, stiffness, free=range(6)):
    """Return the squares of the circular frequencies, ascending, and the torques at rest.

    ``det(K - w^2 M) = 0`` with ``K = Q^T (k Q + dF/dx)``: Q are the rates of the drives, F what the
    drives hold at rest. The forces of the springs turn with the pose as F does, and are equal to F
    at the pose. So only F, which is of the weights alone, is known from differences; Q, M and the
    springs are exact.

    Parameters
    ----------
    tree_at
        Returns the tree of a pose (R, T).
    R, T
        The pose.
    size, metre
        A typical length of the platform in its unit, and that unit in metres.
    stiffness
        Of the drives, in SI units.
    free
        Which of the six velocities the drives leave.
    """
    here, unit_twists = tree_at(R, T), np.eye(6)[list(free)]
    twists = unit_twists * np.repeat([1.0, size * metre], 3)
    rates, mass = here.rates(twists), here.mass(twists)
    bend = np.zeros(rates.shape)
    for column, unit in zip(bend.T, unit_twists, strict=True):
        for n, weight in enumerate(_WEIGHTS, start=1):
            for side in (1, -1):
                twist = side * n * _STEP * unit
                pose = rotation_from_vector(twist[:3]) @ R, T + size * twist[3:]
                column += side * weight / _STEP * tree_at(*pose).forces(*np.zeros((2, 6)))
    K = rates.T @ (stiffness[:, None] * rates + bend)
    # In equilibrium it does not depend on how poses are parametrized.
    assert np.abs(K - K.T).max() < 1e-9 * np.abs(K).max()
    return eigh((K + K.T) / 2, mass, eigvals_only=True), here.forces(*np.zeros((2, 6)))


def soft_springs(instance, R, T, count, hertz):
    """Return a stiffness of the drives at which the lowest frequency is about this many hertz."""
    low = natural_modes(instance, R, T, stiffness=1e6).squares[0, 0]
    return np.full(count, 1e6 * (2 * np.pi * hertz) ** 2 / abs(low))


def frequencies_off(tree, name, seed, hertz):
    """Return how far the squares of the frequencies of a machine with cranks or slides are off.

    As shares, and the torques which its springs hold as a share of the largest.
    """
    rng = np.random.default_rng(seed)
    instance = weighed(driven(name), rng)
    R, T, q = some_pose(instance, rng, least=0.4)
    stiffness = soft_springs(instance, R, T, len(q), hertz)
    found = natural_modes(instance, R, T, stiffness=stiffness)
    drives, numbers = Machine.of(instance), Arrangement.of(instance)
    working_modes = np.sign(drives.gains(R, T, q)).astype(int)

    def tree_at(R, T):
        return tree(rebased(instance, drives.inverse(R, T, working_modes)), R, T)

    metre = METRES[instance.units.length]
    squares, torques = reference_squares(
        tree_at, R, T, numbers.length, metre, stiffness, _free(len(q))
    )
    assert found.squares.shape == (1, len(q))
    held = np.abs(found.torques[0] - torques).max() / np.abs(torques).max()
    return np.abs(found.squares[0] / squares - 1).max(), held


def mass_off(tree, name, seed):
    """Return how far the mass matrix of a machine with cranks or slides is off, as a share."""
    rng = np.random.default_rng(seed)
    instance = weighed(driven(name), rng)
    R, T, numbers = some_pose(instance, rng)
    model = MassModel.of(instance)
    at = R[None], T[None] * model.metre
    q = model.machine.inverse(*at)
    mass, _ = equation_of_motion(model, *at, q, np.zeros((1, 6)))
    pulls = Actuation(model, *at, q).pulls[0, model.machine.first]
    twists = np.eye(6)[list(_free(len(numbers)))]
    found = twists @ (mass[0] + pulls.T * model.rotors @ pulls) @ twists.T
    expected = tree(rebased(instance, numbers), R, T).mass(twists)
    return np.abs(found - expected).max() / np.abs(expected).max()


def _free(count):
    """Return which velocities these drives leave: rods that share one keep it from turning."""
    return range(6) if count == 6 else range(3, 6)
