"""Machines with drives that are not what is stated, and what is measured of them."""

from __future__ import annotations

import numpy as np

from gspcli.calibration.model import Model
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import rotation_from_vector
from tests.support.driven_machines import driven, some_pose

#: Noise of machines of half a metre: lengths in metres, angles in degrees.
SIGMA = {"slide": 1e-5, "crank": 2e-3, "position": 1e-5, "rotation": 1e-3}


def wrong_machine(name, rng, size=1e-3, **chosen):
    """Return a machine as stated and its model with numbers that are off by a part of a length."""
    instance = driven(name)
    model = Model.of(instance, drives=True, **chosen)
    step = size * model.length * model.sizes * rng.normal(size=len(model.free))
    return instance, model.moved(np.where(model.free, step, 0.0))


def reached(instance, truth, rng, count, spread=0.12):
    """Return readings of the drives (radians, lengths), legs (n, 6) and poses of a true machine."""
    drives = Machine.of(instance)
    places = [some_pose(instance, rng, spread) for _ in range(count)]
    R, T, q = (np.array(part) for part in zip(*places, strict=True))
    columns = [drives.names.index(one.drive_name) for one in truth.drives]
    readings = np.stack(
        [one.readings(q[:, k]) for one, k in zip(truth.drives, columns, strict=True)], axis=1
    )
    wanted = np.where(drives.driven, np.nan_to_num(drives.rods), q[:, drives.index])
    bodies = truth.bodies(readings)
    for _ in range(20):
        short = measured(bodies, R, T) - wanted - truth.offsets
        twist = np.linalg.solve(jacobian(bodies, R, T), -short[..., None])[..., 0]
        R, T = rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]
    assert np.abs(short).max() < 1e-12 * truth.length
    legs = np.where(drives.driven, np.nan, wanted)
    return readings, legs, R, T


def noisy(truth, readings, R, T, rng, sigma=SIGMA):
    """Return readings of drives in degrees and lengths, and poses, all with noise."""
    units = np.array([np.pi / 180 if one.sort == "crank" else 1.0 for one in truth.drives])
    off = np.array([sigma[one.sort] for one in truth.drives])
    turn = np.deg2rad(sigma["rotation"]) * rng.normal(size=T.shape)
    return (
        readings / units + off * rng.normal(size=readings.shape),
        rotation_from_vector(turn) @ R,
        T + sigma["position"] * rng.normal(size=T.shape),
    )
