"""What poses do to forces and errors: as plain data of each, and as numbers of all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.dynamics.arrays import make_read_only, plain
from gspcli.dynamics.forces import inverse_dynamics
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import METRES, Array, Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import printed_condition, printed_conditions
from gspcli.motion.files.requirements import QuantityParts
from gspcli.motion.poses.inverse_kinematics import checked_poses, drive_values, refusals
from gspcli.motion.statics.accuracy import Accuracy, GeometryAccuracy, accuracy, geometry_accuracy
from gspcli.motion.statics.wrenches import Wrenches, wrenches
from gspcli.records import EqualByContent, dataclass
from gspcli.wording import counted

if TYPE_CHECKING:
    import pandas as pd

#: What only one pose is shown with.
_LONG = {
    "R",
    "T",
    "point",
    "forces",
    "moments",
    "pitches",
    "feet",
    "jacobian",
    "inverse",
    "stiffness",
}


@dataclass(frozen=True, eq=False)
class Analysis(EqualByContent):
    """All that is known of n poses; None is what was not asked for.

    Attributes
    ----------
    given
        The wrenches of the constraints, with the drives, their gains and transmissions.
    reactions
        Of a load, shape (n, 6).
    stiffness, least_stiffness
        The matrices, shape (n, 6, 6), and the least of the point, shape (n,).
    errors, shape
        From tolerances of the values, and from those of the geometry.
    torques
        What the drives do to hold a load, shape (n, m): of cranks and angles force times length, of
        slides and distances forces.
    """

    given: Wrenches
    reactions: Array | None = None
    stiffness: Array | None = None
    least_stiffness: Array | None = None
    errors: Accuracy | None = None
    shape: GeometryAccuracy | None = None
    torques: Array | None = None

    def __post_init__(self) -> None:
        for part in (self, self.given, self.errors, self.shape):
            if part is not None:
                make_read_only(part)

    @property
    def moves_points(self) -> bool:
        """Whether a drive is a crank or a slide: then drives are told of beside values."""
        return bool(self.given.drives.moved.any())

    def __repr__(self) -> str:
        instance, conditions = self.given.instance, self.given.conditions
        worst = f", condition at most {conditions.max():.3g}" if len(conditions) else ""
        kinds = instance.name or instance.type.id
        return f"<Analysis of {kinds}: {counted(len(conditions), 'pose')}{worst}>"

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose: its condition, and a column for all that was asked for.

        Of forces there are columns ``1`` to ``6``; pandas is imported now.
        """
        import pandas as pd

        given = self.given
        columns = {"condition": given.conditions, "manipulability": given.manipulability}
        if self.reactions is not None:
            columns |= {str(k): column for k, column in enumerate(self.reactions.T, 1)}
        if self.moves_points:
            columns["transmission"] = self.transmissions
            if self.torques is not None:
                motors = [f"torque.{name}" for name in given.drives.names]
                columns |= dict(zip(motors, self.torques.T, strict=True))
        if self.least_stiffness is not None:
            columns["least_stiffness"] = self.least_stiffness
        for part, names in (
            (self.errors, ("worst_turn", "worst_shift", "bound_turn", "bound_shift")),
            (self.shape, ("turn", "shift")),
        ):
            if part is not None:
                prefix = "" if part is self.errors else "geometry_"
                columns |= {prefix + name: getattr(part, name) for name in names}
        return pd.DataFrame(columns)

    def to_json(
        self, names: Sequence[Mapping[str, Any]] | None = None, *, brief: bool = False
    ) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.analyze/1``.

        Parameters
        ----------
        names
            What each pose is called; without it they have no ``mode``.
        brief
            Without matrices and the screws of the constraints.
        """
        count = len(self.given.T)
        called = [{"mode": None}] * count if names is None else names
        left_out = _LONG if brief else ()
        return {
            "schema": "gsp.analyze/1",
            **self.given.instance.to_json(),
            **({"drives": list(self.given.drives.names)} if self.moves_points else {}),
            "length": self.given.length,
            "poses": [
                {**called[k], **{key: x for key, x in self.entry(k).items() if key not in left_out}}
                for k in range(count)
            ],
        }

    def quantities(self) -> dict[str, Array | QuantityParts]:
        """Return the numbers that may be required (`gspcli.motion.files.requirements`)."""
        found: dict[str, Array | QuantityParts] = {
            "condition": printed_conditions(self.given.conditions)
        }
        if self.reactions is not None:
            for load, chosen in (("force", ~self.given.angles), ("moment", self.given.angles)):
                if chosen.any():
                    found[load] = self._loads(chosen)
        if self.moves_points:
            found |= self._of_motors()
        if self.least_stiffness is not None:
            found["stiffness"] = self.least_stiffness
        if self.errors is not None:
            found["error"] = self.errors.bound_shift
        return found

    @property
    def transmissions(self) -> Array:
        """The least transmission of cranks and slides at each pose, shape (n,)."""
        return np.asarray(np.nanmin(self.given.transmissions, axis=1))

    def _of_motors(self) -> dict[str, Array | QuantityParts]:
        """Return the transmissions of cranks and slides, and the torques of cranks."""
        drives = self.given.drives
        moved = np.flatnonzero(drives.driven)
        names = [f"{drives.names[drives.index[k]]}, rod {k + 1}" for k in moved]
        found: dict[str, Array | QuantityParts] = {
            "transmission": QuantityParts(self.given.transmissions[:, moved], names)
        }
        cranks = [k for k, sort in enumerate(drives.sorts) if sort == "crank"]
        if self.torques is not None and cranks:
            turned = [drives.names[k] for k in cranks]
            found["torque"] = QuantityParts(np.abs(self.torques[:, cranks]), turned)
        return found

    def _loads(self, chosen: NDArray[np.bool_]) -> QuantityParts:
        assert self.reactions is not None
        names = [f"constraint {k + 1}" for k in np.flatnonzero(chosen)]
        return QuantityParts(np.abs(self.reactions[:, chosen]), names)

    def entry(self, k: int) -> dict[str, Any]:
        """Return all that is known of one pose, as plain data."""
        given = self.given
        constraint, direction, reaction = given.worst_force
        entry: dict[str, Any] = {
            "R": given.R[k].tolist(),
            "T": given.T[k].tolist(),
            "point": given.point[k].tolist(),
            "condition": plain(printed_condition(given.conditions[k])),
            "manipulability": float(given.manipulability[k]),
            "singular_values": given.singular_values[k].tolist(),
            "forces": given.forces[k].tolist(),
            "moments": given.moments[k].tolist(),
            "pitches": plain(given.pitches[k]),
            "feet": plain(given.feet[k]),
            "jacobian": given.jacobian[k].tolist(),
            "inverse": plain(given.inverse[k]),
            "worst_force": {
                "constraint": int(constraint[k]) + 1,
                "direction": plain(direction[k]),
                "reaction": plain(reaction[k]),
            },
        }
        return entry | self._asked(k)

    def _asked(self, k: int) -> dict[str, Any]:
        """Return what was asked for."""
        entry: dict[str, Any] = {}
        if self.moves_points:
            entry["drives"] = self.given.drives.readings(self.given.q[k]).tolist()
            entry["transmissions"] = plain(self.given.transmissions[k])
            entry["transmission"] = float(self.transmissions[k])
            if self.torques is not None:
                entry["torques"] = plain(self.torques[k])
        if self.reactions is not None:
            entry["reactions"] = plain(self.reactions[k])
        if self.stiffness is not None and self.least_stiffness is not None:
            entry["stiffness"] = self.stiffness[k].tolist()
            entry["least_stiffness"] = plain(self.least_stiffness[k])
        errors, shape = self.errors, self.shape
        if errors is not None:
            entry["accuracy"] = {name: plain(x[k]) for name, x in vars(errors).items()}
        if shape is not None:
            entry["geometry"] = {name: plain(x[k]) for name, x in vars(shape).items()}
        return entry


def analyze(
    instance: Instance,
    R: Any,
    T: ArrayLike | None = None,
    *,
    load: ArrayLike | None = None,
    at: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
    tolerance: ArrayLike | None = None,
    geometry_tolerance: ArrayLike | None = None,
    point: ArrayLike | None = None,
    length: float | None = None,
    drives: ArrayLike | None = None,
) -> Analysis:
    """Analyze poses: screws, Jacobian matrices, forces, stiffness and accuracy.

    Parameters
    ----------
    instance
        The platform; its weights count if it states masses, its tolerances unless others are given.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    load
        Force, or force and moment, on the platform, in the axes of the base, shape (3,) or (6,).
    at
        Where the load acts, shape (3,); by default at the point.
    stiffness, tolerance
        The stiffness of the constraints, and how far each value may be off: one number or six. A
        stiffness is a force of the load's unit over a length of the instance's unit; for angles it
        is a moment over a radian. By default it is that of the drives, if the instance states one,
        converted to newtons over that unit.
    geometry_tolerance
        How far each coordinate of each primitive may be off, or that and the turn of directions.
    point
        What twists and wrenches are about, shape (3,); by default the mean of the platform's
        points at each pose.
    length
        What makes angles and lengths comparable; by default the typical length.
    drives
        The readings of the m drives of an instance with cranks or slides, shape (n, m) or (m,). By
        default those that reach the poses in the working modes of home.

    Raises
    ------
    ArgumentError
        Naming what is wrong.
    """
    R, T = checked_poses(R, T)
    R, T = R.reshape(-1, 3, 3), T.reshape(-1, 3)
    machine, q = _places(instance, R, T, drives)
    given = wrenches(instance, R, T, point=point, length=length, drives=machine, q=q)
    reactions, torques = _loads(given, load, at)
    rods = None if stiffness is None else _six(stiffness, "stiffness")
    motors = _motor_stiffness(instance, machine)
    compliance = None if motors is None and rods is None else given.compliance(motors, rods)
    limits = _stated(instance) if tolerance is None else _six(tolerance, "tolerance")
    off = np.where(machine.moved & np.isfinite(machine.tolerances), machine.tolerances, 0.0)
    if limits is None and off.any():
        limits = [0.0] * 6
    return Analysis(
        given,
        reactions,
        None if compliance is None else given.stiffness(compliance),
        None if compliance is None else given.least_stiffness(compliance),
        None if limits is None else accuracy(given, limits, off),
        None if geometry_tolerance is None else _shape(given, geometry_tolerance),
        torques,
    )


def _places(
    instance: Instance, R: Array, T: Array, given: ArrayLike | None
) -> tuple[Machine, Array]:
    """Return the drives and where they are at poses, shape (n, m).

    Raises
    ------
    ArgumentError
        If a pose is out of reach.
    """
    if given is None:
        drives, q = drive_values(instance, R, T, along=False)
        if missing := refusals(drives, R, T, q):
            row = min(missing)
            raise ArgumentError(missing[row], f"pose {row + 1} of {len(T)}")
        return drives, q
    drives = Machine.of(instance)
    q = drives.from_readings(np.asarray(given, float))
    return drives, np.array(np.broadcast_to(q, (len(T), drives.count)))


def _loads(
    given: Wrenches, load: ArrayLike | None, at: ArrayLike | None
) -> tuple[Array | None, Array | None]:
    """Return what the constraints and the drives do to hold a load and the weights that are stated.

    Shapes (n, 6) and (n, m); None for neither.
    """
    instance, drives = given.instance, given.drives
    reactions = torques = None
    if load is not None:
        numbers = np.resize(np.append(_numbers(load, (3, 6), "load"), np.zeros(3)), 6)
        place = given.point if at is None else _numbers(at, (3,), "at")
        reactions = given.reactions(numbers[:3], numbers[3:], place)
        torques = given.torques(reactions)
    if instance.dynamics is not None:
        places = drives.readings(given.q)
        weights = inverse_dynamics(instance, given.R, given.T, drives=places)
        turns = np.array([unit == "N m" for unit in weights.torque_units])
        moved = weights.torques / np.where(turns, METRES[instance.units.length], 1.0)
        reactions = weights.in_file_units + (0.0 if reactions is None else reactions)
        torques = moved + (0.0 if torques is None else torques)
    return reactions, torques


def _motor_stiffness(instance: Instance, drives: Machine) -> Array | None:
    """Return the stiffness of m drives if an instance states it: in N and its unit of length."""
    if instance.dynamics is None or instance.dynamics.drives.stiffness is None:
        return None
    metre = METRES[instance.units.length]
    numbers = [number.value for number in instance.dynamics.drives.stiffness]
    return np.resize(numbers, drives.count) * np.where(drives.turns, 1 / metre, metre)


def _numbers(given: ArrayLike, counts: Sequence[int], name: str) -> Array:
    numbers = np.atleast_1d(np.asarray(given, float)).ravel()
    if len(numbers) not in counts or not np.isfinite(numbers).all():
        expected = " or ".join(map(str, counts))
        message = f"found {numbers.tolist()}, expected {expected} finite numbers"
        raise ArgumentError(message, name)
    return numbers


def _six(given: ArrayLike, name: str) -> list[float]:
    numbers: list[float] = np.resize(_numbers(given, (1, 6), name), 6).tolist()
    return numbers


def _stated(instance: Instance) -> list[float] | None:
    """Return the tolerances of an instance if it has any; those left out are zero."""
    stated = [constraint.tolerance for constraint in instance.constraints]
    if all(tolerance is None for tolerance in stated):
        return None
    return [0.0 if tolerance is None else tolerance.value for tolerance in stated]


def _shape(given: Wrenches, tolerance: ArrayLike) -> GeometryAccuracy:
    numbers = _numbers(tolerance, (1, 2), "geometry_tolerance")
    if numbers.min() < 0:
        message = f"found {numbers.min():g}, expected numbers of at least 0"
        raise ArgumentError(message, "geometry_tolerance")
    return geometry_accuracy(given, *numbers.tolist())
