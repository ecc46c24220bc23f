"""Gaps between legs and bodies at poses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry.instance import Instance
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.poses.inverse_kinematics import checked_poses
from gspcli.records import dataclass
from gspcli.ties import first_smallest

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Gaps:
    """The gaps of p pairs of legs and bodies at n poses.

    Attributes
    ----------
    pairs
        Names of the p pairs, such as ``legs 2 and 5`` or ``leg 3 and the base``. A leg has the
        number of its constraint.
    values
        The gaps, shape (n, p), in the unit of length; negative where the shapes overlap.
    """

    pairs: tuple[str, ...]
    values: Array

    def __repr__(self) -> str:
        least = f", at least {self.least.min():.6g}" if len(self.values) else ""
        return f"<Gaps of {len(self.pairs)} pairs at {len(self.values)} poses{least}>"

    @property
    def least(self) -> Array:
        """The least gap at each pose, shape (n,)."""
        return np.asarray(self.values.min(axis=1))

    @property
    def nearest(self) -> list[str]:
        """The pair with the least gap at each pose, the first one of equal ones.

        Empty where a rod does not reach the pose, so that the gap is not known.
        """
        known = np.asarray(~np.isnan(self.values).any(axis=1))
        return [
            self.pairs[int(first_smallest(row))] if there else ""
            for row, there in zip(self.values, known.tolist(), strict=True)
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose, a column for each pair (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.values, columns=[*self.pairs])

    def to_json(self) -> list[dict[str, Any]]:
        """Return the least gap of each pose and its pair, as plain data."""
        return [
            {"gap": gap if pair else None, "gap_between": pair or None}
            for gap, pair in zip(self.least.tolist(), self.nearest, strict=True)
        ]


def gaps(instance: Instance, R: ArrayLike, T: ArrayLike) -> Gaps:
    """Return the gaps between legs and bodies at poses.

    Parameters
    ----------
    instance
        The platform, with the shapes of its legs (`gspcli.Shapes`).
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), or one pose.

    Raises
    ------
    ArgumentError
        If the platform states no shapes, or if the poses have the wrong shapes.

    Examples
    --------
    >>> import dataclasses
    >>> import gspcli
    >>> import numpy as np
    >>> platform = gspcli.example("workspace-study")
    >>> platform = dataclasses.replace(platform, shapes=gspcli.Shapes(diameters=20))
    >>> gspcli.motion.gaps(platform, np.eye(3), [0, 0, 400]).to_json()
    [{'gap': 23.41204442, 'gap_between': 'legs 1 and 6'}]
    """
    R, T = checked_poses(R, T)
    compared = ComparedShapes(instance)
    return Gaps(compared.names, compared.gaps(R.reshape(-1, 3, 3), T.reshape(-1, 3)))
