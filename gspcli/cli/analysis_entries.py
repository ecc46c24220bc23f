"""What `gsp analyze` computes of poses: as plain data of each, and as numbers of all."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.motion.files.requirements import Parts
    from gspcli.motion.statics.accuracy import Accuracy
    from gspcli.motion.statics.geometry_errors import GeometryAccuracy
    from gspcli.motion.statics.wrenches import Wrenches

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Analysis:
    """All that is known of n poses; None is what was not asked for.

    Attributes
    ----------
    given
        The wrenches of the constraints.
    reactions
        Of a load, shape (n, 6).
    stiffness, least_stiffness
        The matrices, shape (n, 6, 6), and the least of the point, shape (n,).
    errors, shape
        From tolerances of the values, and from those of the geometry.
    """

    given: Wrenches
    reactions: Array | None = None
    stiffness: Array | None = None
    least_stiffness: Array | None = None
    errors: Accuracy | None = None
    shape: GeometryAccuracy | None = None

    def quantities(self) -> dict[str, Array | Parts]:
        """Return the numbers that may be required (`gspcli.motion.files.requirements`)."""
        found: dict[str, Array | Parts] = {"condition": self.given.conditions}
        if self.reactions is not None:
            for name, chosen in (("force", ~self.given.angles), ("moment", self.given.angles)):
                if chosen.any():
                    found[name] = self._loads(chosen)
        if self.least_stiffness is not None:
            found["stiffness"] = self.least_stiffness
        if self.errors is not None:
            found["error"] = self.errors.bound_shift
        return found

    def _loads(self, chosen: NDArray[np.bool_]) -> Parts:
        import numpy as np

        from gspcli.motion.files.requirements import Parts

        assert self.reactions is not None
        names = [f"constraint {k + 1}" for k in np.flatnonzero(chosen)]
        return Parts(np.abs(self.reactions[:, chosen]), names)

    def entry(self, k: int) -> dict[str, Any]:
        """Return all that is known of one pose, as plain data."""
        given = self.given
        constraint, direction, reaction = given.worst_force
        entry: dict[str, Any] = {
            "R": given.R[k].tolist(),
            "T": given.T[k].tolist(),
            "point": given.point[k].tolist(),
            "condition": finite(given.conditions[k]),
            "manipulability": float(given.manipulability[k]),
            "singular_values": given.singular_values[k].tolist(),
            "forces": given.forces[k].tolist(),
            "moments": given.moments[k].tolist(),
            "pitches": [finite(pitch) for pitch in given.pitches[k]],
            "feet": [[finite(x) for x in foot] for foot in given.feet[k]],
            "jacobian": given.jacobian[k].tolist(),
            "inverse": [[finite(x) for x in row] for row in given.inverse[k]],
            "worst_force": {
                "constraint": int(constraint[k]) + 1,
                "direction": [finite(x) for x in direction[k]],
                "reaction": finite(reaction[k]),
            },
        }
        return entry | self._asked(k)

    def _asked(self, k: int) -> dict[str, Any]:
        """Return what was asked for."""
        entry: dict[str, Any] = {}
        if self.reactions is not None:
            entry["reactions"] = [finite(x) for x in self.reactions[k]]
        if self.stiffness is not None and self.least_stiffness is not None:
            entry["stiffness"] = self.stiffness[k].tolist()
            entry["least_stiffness"] = finite(self.least_stiffness[k])
        errors, shape = self.errors, self.shape
        if errors is not None:
            entry["accuracy"] = {
                name: [finite(x) for x in getattr(errors, name)[k]]
                for name in ("worst", "bound", "rms")
            } | {
                name: finite(getattr(errors, name)[k])
                for name in ("worst_turn", "worst_shift", "bound_turn", "bound_shift")
            }
        if shape is not None:
            entry["geometry"] = {
                "worst": [finite(x) for x in shape.worst[k]],
                "rms": [finite(x) for x in shape.rms[k]],
                "turn": finite(shape.turn[k]),
                "shift": finite(shape.shift[k]),
            }
        return entry


def finite(value: Any) -> float | None:
    """Return a number for JSON, which has none that is not finite."""
    number = float(value)
    return number if abs(number) < float("inf") else None
