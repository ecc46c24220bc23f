"""The columns of the least gap between legs and bodies, of platforms that state their shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gspcli.cli.output import Column

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion.files.requirements import QuantityParts

    Array = NDArray[np.float64]


def add_gaps(
    instance: Instance, R: Array, T: Array, rows: Sequence[dict[str, Any]]
) -> tuple[list[Column], dict[str, Array | QuantityParts]]:
    """Add to rows the least gap of each pose, and what it is between; nothing without shapes.

    Returns
    -------
    columns, known
        What is added, and the gaps for `gspcli.cli.requirements.judged`.
    """
    if instance.shapes is None:
        return [], {}
    from gspcli.motion.collisions.leg_gaps import gaps
    from gspcli.motion.files.requirements import QuantityParts

    found = gaps(instance, R, T)
    for row, said in zip(rows, found.to_json(), strict=True):
        row |= said
    columns = [
        Column("gap", align="right", essential=True),
        Column("gap_between", "between", essential=True),
    ]
    return columns, {"gap": QuantityParts(found.values, found.pairs)}
