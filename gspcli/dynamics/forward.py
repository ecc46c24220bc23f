"""Forward dynamics: how a platform moves when its drives push with given forces.

The equations are integrated in the space of poses: translation, quaternion, twist. So there are no
closed loops that errors could open. Only the energy drifts, and the drift is measured: each result
states how far the work of the drives is from the change of the energy.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.dynamics.arrays import checked_array, checked_rows, make_read_only, plain
from gspcli.dynamics.drives import DrivesAtPoses
from gspcli.dynamics.mass_model import MassModel
from gspcli.dynamics.moved_points import Knees, driven_numbers, given_numbers
from gspcli.dynamics.moving_bodies import MovingBodies, equation_of_motion
from gspcli.dynamics.shared_drives import check_shared, closed
from gspcli.dynamics.trajectories import (
    ACCELERATION,
    VELOCITY,
    PoseRates,
    check_times,
    expressed_motion,
)
from gspcli.errors import ArgumentError, GspError, IncompleteError
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.printed_numbers import one_digit
from gspcli.geometry.quaternions import (
    apply,
    dot,
    quaternion_from_rotation,
    quaternion_product,
    rotation_from_quaternion,
)
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: Relative accuracy of a step, and the absolute one in metres, radians and seconds.
_RELATIVE, _ABSOLUTE = 1e-11, 1e-14
#: Of the energy's changes: errors below this are those of rounding.
_ROUNDING = 1e-12
#: Calls of the equations of motion before a simulation is given up.
_MOST_CALLS = 200_000
#: After this many evaluations a motion ends that at this rate would need this many times the most.
_FIRST_CALLS, _HOPELESS = 3000, 10
#: The columns of a pose in files.
POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """A motion at n times. All arrays are read-only.

    Attributes
    ----------
    instance
        The platform.
    t
        Times in seconds, shape (n,).
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), in length units.
    twists, accelerations
        Angular velocity (rad/s) and velocity of the platform's origin (length units/s) in the axes
        of the base, and their derivatives, shape (n, 6).
    forces
        Of the drives, N and N m, shape (n, 6), or one column for each drive.
    kinetic, potential, work
        Energies of all bodies and the work of the drives since the first row, J, shape (n,).
    """

    instance: Instance
    t: Array
    R: Array
    T: Array
    twists: Array
    accelerations: Array
    forces: Array
    kinetic: Array
    potential: Array
    work: Array

    def __post_init__(self) -> None:
        make_read_only(self)

    def __repr__(self) -> str:
        name = self.instance.name or self.instance.type.id
        return (
            f"<SimulatedMotion of {name}: {self.t[-1] - self.t[0]:g} s in {len(self.t)} rows, "
            f"energy off by {self.shown_error:.0e} of its changes>"
        )

    @cached_property
    def energy_error(self) -> float:
        """How far the energy is from what the drives put in, by the largest change of a part."""
        energy = self.kinetic + self.potential
        parts = (self.kinetic, self.potential - self.potential[0], self.work)
        size = max(float(np.abs(part).max()) for part in parts)
        return float(np.abs(energy - energy[0] - self.work).max()) / (size or 1.0)

    @property
    def shown_error(self) -> float:
        """An upper bound of `energy_error` with one digit, which rounding errors do not change."""
        return one_digit(max(self.energy_error, _ROUNDING))

    @cached_property
    def quaternions(self) -> Array:
        """Unit quaternions of the rotations, scalar first, continuous along the motion (n, 4)."""
        return _continuous(self.R)

    @cached_property
    def table(self) -> dict[str, Array]:
        """The rows by columns, angles in the unit of the instance.

        ``t``, the pose, VELOCITY and ACCELERATION: what `gsp dynamics` reads; then the energies.
        """
        return self.expressed()

    def expressed(self, frame: PoseFrame = IDENTITY) -> dict[str, Array]:
        """Return `table` with poses and their motion as they are expressed in a frame."""
        R, T = frame.from_platform(self.R, self.T)
        motion = expressed_motion(frame, self.R, PoseRates(self.twists, self.accelerations))
        angle = np.repeat([1 / self.instance.units.angle.in_radians, 1.0], 3)
        columns = {"t": self.t}
        columns |= zip(POSE, np.concatenate((T, _continuous(R)), axis=1).T, strict=True)
        columns |= zip(VELOCITY, (motion.twists * angle).T, strict=True)
        columns |= zip(ACCELERATION, (motion.accelerations * angle).T, strict=True)
        energies = {"kinetic": self.kinetic, "potential": self.potential, "work": self.work}
        return columns | energies

    def to_frame(self) -> pd.DataFrame:
        """Return `table` as a data frame."""
        import pandas as pd

        return pd.DataFrame(self.table)

    def to_json(self, frame: PoseFrame = IDENTITY) -> dict[str, Any]:
        """Return everything as plain data, with poses as they are expressed in a frame."""
        columns = {name: plain(column) for name, column in self.expressed(frame).items()}
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        return {
            "schema": "gsp.dynamics-motion/1",
            **self.instance.to_json(),
            "energy_error": self.shown_error,
            **({} if frame.is_identity else {"frames": frame.to_json()}),
            "rows": rows,
        }


def _continuous(R: Array) -> Array:
    """Return unit quaternions of rotations, with signs that do not change along them, (n, 4)."""
    e = quaternion_from_rotation(R)
    e[1:] *= np.where(dot(e[1:], e[:-1]) < 0, -1.0, 1.0).cumprod()[:, None]
    return e


def forward_dynamics(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    twists: ArrayLike,
    forces: ArrayLike,
    *,
    drives: ArrayLike | None = None,
) -> Array:
    """Return the accelerations of a platform under forces of its drives, shape (n, 6).

    Parameters
    ----------
    instance
        A platform with masses.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), in length units; singular ones as well.
    twists
        Angular velocities (rad/s) and velocities of the platform's origin, shape (n, 6) or (6,).
    forces
        Forces of the drives (N) and torques (N m for angles and cranks), shape (n, 6) or (6,); m
        instead of six where rods share drives.
    drives
        Where the drives are, as `inverse_dynamics`.

    Raises
    ------
    ArgumentError
        As `inverse_dynamics`.
    """
    model = MassModel.of(instance)
    R, T = checked_rows(R, T)
    t = model.in_metres(checked_array(twists, (len(R), 6), "twists"))
    F = checked_array(forces, (len(R), model.drive_count), "forces")
    numbers = given_numbers(model, R, T * model.metre, drives)
    found, _ = _accelerations(model, R, T * model.metre, t, F, numbers)
    return np.asarray(found / np.repeat([1.0, model.metre], 3))


def _accelerations(
    model: MassModel, R: Array, T: Array, twists: Array, forces: Array, numbers: Array | None
) -> tuple[Array, Array]:
    """Return accelerations and what the drives do (W), in metres, shapes (n, 6) and (n,)."""
    drives = DrivesAtPoses(model, R, T, numbers)
    forces = model.by_constraints(forces)
    columns = np.swapaxes(drives.pulls, -1, -2)
    mass, needed = equation_of_motion(model, R, T, twists, numbers)
    mass = mass + columns * model.rotors @ drives.pulls
    pushed = apply(columns, forces - drives.inertial(twists, np.zeros_like(twists)))
    power = dot(forces, apply(drives.pulls, twists))
    if model.sharing is None:
        return np.linalg.solve(mass, (pushed - needed)[..., None])[..., 0], power
    # The rods of one drive leave the motions of the drives: t' = J^-1 (E q'' - bend).
    basis = np.linalg.solve(drives.pulls, model.sharing)
    bent = np.linalg.solve(drives.pulls, drives.bends(twists)[..., None])[..., 0]
    down = np.swapaxes(basis, -1, -2)
    right = apply(down, pushed - needed + apply(mass, bent))
    rates = np.linalg.solve(down @ mass @ basis, right[..., None])[..., 0]
    return apply(basis, rates) - bent, power


def simulate(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    t: ArrayLike,
    forces: ArrayLike,
    *,
    twist: ArrayLike = 0.0,
    drives: ArrayLike | None = None,
) -> SimulatedMotion:
    """Return how a platform moves from a pose under forces that are linear between times.

    Parameters
    ----------
    instance
        A platform with masses.
    R, T
        The pose at the first time, shapes (3, 3) and (3,), in length units.
    t
        Times in seconds, increasing, shape (n,).
    forces
        Of the drives at these times, N and N m, shape (n, 6) or (6,), of cranks their torques; m
        instead of six where rods share drives.
    twist
        How the platform moves at first: angular velocity (rad/s) and velocity of its origin (length
        units/s), shape (6,). At rest by default.
    drives
        Where the drives are at first, as `inverse_dynamics`; their knees stay the same.

    Raises
    ------
    ArgumentError
        If an argument has a wrong shape or number.
    IncompleteError
        If the platform gets where a value has no derivative, or moves too wildly to be followed.
    GspError
        If SciPy is missing.

    Notes
    -----
    Runge and Kutta's method of order 8 (SciPy's ``DOP853``) with a relative accuracy of 1e-11 a
    step. `SimulatedMotion.energy_error` has the result.
    """
    model = MassModel.of(instance)
    R, T = checked_rows(R, T)
    if len(R) != 1:
        message = f"found {len(R)} poses, expected one to start from"
        raise ArgumentError(message, "R, T")
    times = np.asarray(t, float)
    if times.ndim != 1 or len(times) < 2:
        message = f"found shape {times.shape}, expected (n,): two times at least"
        raise ArgumentError(message, "t")
    times = checked_array(times, times.shape, "t")
    check_times(times)
    F = checked_array(forces, (len(times), model.drive_count), "forces")
    first = model.in_metres(checked_array(twist, (6,), "twist"))
    e = quaternion_from_rotation(R)[0]
    numbers = given_numbers(model, R, T * model.metre, drives)
    knees: Knees | None = None
    if numbers is not None:
        moving = DrivesAtPoses(model, R, T * model.metre, numbers)
        check_shared(moving, first[None])
        assert moving.points is not None
        knees = np.where(moving.points.gains[0] > 0, 1, -1)
    start = np.concatenate((T[0] * model.metre, e, first, [0.0]))
    states = _integrate(model, start, times, F, knees)
    return _described(model, times, states, F, knees)


def _integrate(
    model: MassModel, start: Array, times: Array, forces: Array, knees: Knees | None
) -> Array:
    """Return the states (T, quaternion, twist, work) in metres at times, shape (n, 14)."""
    try:
        from scipy.integrate import DOP853
    except ImportError as error:
        message = "simulations need SciPy, which is missing: pip install 'gspcli[dynamics]'"
        raise GspError(message) from error

    def change(t: float, state: Array, low: int) -> Array:
        span = times[low + 1] - times[low]
        F = forces[low] + (forces[low + 1] - forces[low]) * ((t - times[low]) / span)
        R, twist = rotation_from_quaternion(state[None, 3:7]), state[None, 7:13]
        numbers = driven_numbers(model, R, state[None, :3], knees)
        a, power = _accelerations(model, R, state[None, :3], twist, F[None], numbers)
        turn = quaternion_product(np.concatenate(([0.0], twist[0, :3])), state[3:7]) / 2
        return np.concatenate((twist[0, 3:], turn, a[0], power))

    states, calls, step = [start], 0, None
    for low in range(len(times) - 1):
        try:
            solver = DOP853(
                lambda t, state, low=low: change(t, state, low),
                times[low],
                states[-1],
                times[low + 1],
                rtol=_RELATIVE,
                atol=_ABSOLUTE,
                first_step=None if step is None else min(step, times[low + 1] - times[low]),
            )
            while solver.status == "running" and calls + solver.nfev < _MOST_CALLS:
                solver.step()
                part = (solver.t - times[0]) / (times[-1] - times[0])
                so_far = calls + solver.nfev
                if so_far > max(_FIRST_CALLS, _HOPELESS * _MOST_CALLS * part):
                    break
        except ArgumentError as error:
            where = f"between t = {times[low]:g} and {times[low + 1]:g}"
            message = f"the motion ends {where}: {error.message}"
            raise IncompleteError(message) from None
        if solver.status != "finished":
            message = (
                f"the motion cannot be followed beyond t = {solver.t:.6g}: it is too wild there\n"
                "give forces that hold the platform (their units are N and N m), or fewer times"
            )
            raise IncompleteError(message)
        calls += solver.nfev
        step = solver.h_abs
        # The norm of a quaternion means nothing, and is kept by the equations but for rounding.
        state = solver.y.copy()
        state[3:7] /= np.linalg.norm(state[3:7])
        states.append(state if model.sharing is None else closed(model, state, knees))
    return np.array(states)


def _described(
    model: MassModel, times: Array, states: Array, F: Array, knees: Knees | None
) -> SimulatedMotion:
    """Return the result of states in metres."""
    T, R, twists = states[:, :3], rotation_from_quaternion(states[:, 3:7]), states[:, 7:13]
    numbers = driven_numbers(model, R, T, knees)
    accelerations, _ = _accelerations(model, R, T, twists, F, numbers)
    drives = DrivesAtPoses(model, R, T, numbers)
    bodies = MovingBodies(model, R, T, drives.points)
    mass, _ = equation_of_motion(model, R, T, twists, numbers)
    rates = apply(drives.pulls, twists)
    kinetic = (dot(twists, apply(mass, twists)) + rates**2 @ model.rotors) / 2
    unit = np.repeat([1.0, model.metre], 3)
    return SimulatedMotion(
        model.instance,
        times,
        R,
        T / model.metre,
        twists / unit,
        accelerations / unit,
        F,
        kinetic,
        bodies.potential(),
        states[:, 13],
    )
