"""Values at poses as an array that can be converted to a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry.instance import Instance
from gspcli.motion.poses.inverse_kinematics import measure as measured
from gspcli.wording import counted

if TYPE_CHECKING:
    import pandas as pd


class MeasuredValues(np.ndarray[Any, np.dtype[np.float64]]):
    """Values at poses, shape (..., 6): a read-only array with the platform as an attribute.

    Attributes
    ----------
    instance
        The platform; None for arrays that were computed from the values.
    """

    instance: Instance | None

    def __array_finalize__(self, source: NDArray[Any] | None) -> None:
        """Give arrays that are computed from the values no platform."""
        self.instance = None

    def __repr__(self) -> str:
        if self.instance is None:
            return repr(np.asarray(self))
        kinds = self.instance.name or self.instance.type.id
        return f"<MeasuredValues of {kinds}: {counted(self.size // 6, 'pose')}>"

    def _rows(self) -> list[list[float]]:
        rows: list[list[float]] = np.asarray(self).reshape(-1, 6).tolist()
        return rows

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose, with the columns ``1`` to ``6`` (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self._rows(), columns=list("123456"))

    def to_json(self, t: Sequence[float] | None = None) -> dict[str, Any]:
        """Return the values as plain data of schema ``gsp.measure/1``.

        Parameters
        ----------
        t
            The column t of the rows; without it their numbers from 1.
        """
        assert self.instance is not None
        rows = self._rows()
        constraints = self.instance.constraints
        sided = [k for k, row in enumerate(constraints, 1) if row.kind.has_sides]
        poses = [
            {
                "t": time,
                "values": row,
                "sides": {str(k): "negative" if row[k - 1] < 0 else "positive" for k in sided},
            }
            for time, row in zip(t or range(1, len(rows) + 1), rows, strict=True)
        ]
        return {"schema": "gsp.measure/1", **self.instance.to_json(), "poses": poses}


def measure(instance: Instance, R: Any, T: ArrayLike | None = None) -> MeasuredValues:
    """Return the values of all constraints at poses, in the units of the instance.

    As `gspcli.motion.measure`, with the platform as an attribute. Distances to planes (DPH and DHP)
    are signed, all others at least zero; the results are readings, without offsets and scales.

    Parameters
    ----------
    instance
        The geometry and units; its own values are not used.
    R, T
        The poses, shapes (..., 3, 3) and (..., 3): ``x_base = R x_platform + T``. R may be a
        `Rotation` of SciPy, and without T a pose: a pair (R, T), or a mode of a result.

    Raises
    ------
    ArgumentError
        If the arrays have other shapes or numbers that are not finite.

    Examples
    --------
    >>> import gspcli
    >>> import numpy as np
    >>> platform = gspcli.example("workspace-study")
    >>> values = gspcli.measure(platform, np.eye(3), [0, 0, 400])
    >>> values.round(3).tolist()[:2]
    [423.683, 423.683]
    """
    values = measured(instance, R, T).view(MeasuredValues)
    values.instance = instance
    values.setflags(write=False)
    return values
