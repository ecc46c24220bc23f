"""The equations on the parts of the way between two rows, each computed once and kept."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.chord_residuals import ExactChords
from gspcli.certification.branches.taylor import MovingQuadrics, MovingSystem
from gspcli.motion.following.chord_equations import DEGREE

Array = NDArray[np.float64]

#: Largest relative remainder of the polynomials on a part; otherwise the part is halved.
_LEFT_OUT = 2.0**-38


class PartModels:
    """The equations between two rows: polynomials on as many parts as are needed.

    Parameters
    ----------
    system
        The moving instance.
    rows
        The row before and the next one, in the units of the instance.
    """

    def __init__(self, system: MovingSystem, rows: tuple[Array, Array]) -> None:
        self.system = system
        self.rows = rows
        self._of_part = lru_cache(maxsize=None)(self._found)
        self.piece = lru_cache(maxsize=256)(self._piece)
        self.exact = lru_cache(maxsize=256)(self._exact)

    def _found(self, part: int, level: int) -> MovingQuadrics | None:
        """Return the equations on a part, if the remainders of the polynomials are small."""
        size = 2.0**-level
        found = self.system.on_part(self.rows, part * size, (part + 1) * size)
        scale = np.sqrt((found.quadrics[:, :, 0] ** 2).sum(axis=(2, 3)))
        good = (found.errors <= _LEFT_OUT * scale + 2.0**-60).all()
        good &= (found.factor_errors <= _LEFT_OUT).all()
        return found if good else None

    def _piece(self, part: int, level: int) -> MovingQuadrics | None:
        """Return the equations on a part, from the longest part around it with small remainders.

        The part is one of 2^``level``. The result is None if the remainders are too large on all of
        these parts.
        """
        for k in range(level + 1):
            around = self._of_part(part >> (level - k), k)
            if around is not None:
                size = 2.0 ** (k - level)
                begin = (part - ((part >> (level - k)) << (level - k))) * size - 0.5
                return around.restricted(begin, begin + size, DEGREE)
        return None

    def _exact(self, part: int, level: int) -> ExactChords:
        """Return the equations on a part in balls."""
        size = 2.0**-level
        return ExactChords(self.system, self.rows, part * size, (part + 1) * size)
