"""The ends of a path: modes by their numbers, home, or poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.home_mode import HomeMode, home_mode
from gspcli.geometry.instance import Instance
from gspcli.motion.poses.inverse_kinematics import checked_poses, pose_parts, values_at
from gspcli.motion.poses.mode_filters import chosen_mode
from gspcli.records import dataclass
from gspcli.solver import SolveResult, solve
from gspcli.solver.result import Solution

Array = NDArray[np.float64]
#: A mode by its number, ``home``, or a pose: (R, T), or a mode of a result.
End = int | str | tuple[ArrayLike, ArrayLike] | HomeMode | Solution


@dataclass(frozen=True, eq=False)
class PathEnd:
    """A pose with its values, and its name in messages.

    Attributes
    ----------
    name
        Such as ``mode 3``.
    values
        Shape (6,), distances to planes signed, without offsets; of a mode the stated ones.
    R, T
        The pose, shapes (3, 3) and (3,).
    """

    name: str
    values: Array
    R: Array
    T: Array

    @property
    def is_mode(self) -> bool:
        """Whether it is a mode of the stated values, with all drives where they are stated."""
        return self.name.startswith("mode ")


class Modes:
    """The real poses of a platform as ends of paths, solved when they are first needed.

    Parameters
    ----------
    instance
        The platform.
    solved
        Its poses, if they are known.
    """

    def __init__(self, instance: Instance, solved: SolveResult | None = None) -> None:
        self.instance = instance
        self._solved = solved

    def all(self) -> list[PathEnd]:
        """Return all modes, in the order of `solve`.

        Raises
        ------
        NotFiniteError, IncompleteError
            If they are infinitely many, or could not all be found.
        """
        if self._solved is None:
            self._solved = solve(self.instance)
        found = self._solved
        if found.verdict == "infinite":
            raise NotFiniteError(
                "the poses of the platform are infinitely many: give poses, not modes"
            )
        if found.verdict != "complete":
            raise IncompleteError(
                "the poses of the platform could not all be found: give poses, not modes"
            )
        R, T = found.R[found.real].real, found.T[found.real].real
        stated = Arrangement.of(self.instance).values
        values = np.where(values_at(self.instance, R, T) < 0, -stated, stated)
        return [
            PathEnd(f"mode {k}", *one) for k, one in enumerate(zip(values, R, T, strict=True), 1)
        ]

    def end(self, given: End, name: str) -> PathEnd:
        """Return an end as it is given.

        Parameters
        ----------
        given
            A number, ``home``, or a pose: (R, T), or a mode of a result.
        name
            Of the argument, for messages and for the name of a pose.
        """
        if isinstance(given, str) and given != "home":
            raise ArgumentError(
                f"found {given!r}, expected a number of solve, home, or a pose (R, T)", name
            )
        if isinstance(given, int | np.integer | str):
            modes = self.all()
            R = np.array([one.R for one in modes]).reshape(-1, 3, 3)
            T = np.array([one.T for one in modes]).reshape(-1, 3)
            number = None if isinstance(given, str) else int(given)
            return modes[chosen_mode(number, home_mode(self.instance, R, T), len(modes)) - 1]
        R, T = checked_poses(*pose_parts(given, name))
        if R.ndim != 2:
            raise ArgumentError(f"found {R.shape[:-2]} poses, expected one", name)
        return PathEnd(f"the {name}", values_at(self.instance, R, T), R, T)
