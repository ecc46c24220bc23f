"""A random instance to start from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gspcli.catalogue.coincidence import Bond
from gspcli.catalogue.types import GspType
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.solver.instances.generate import random_instance


def new(
    pattern: GspType | Sequence[Bond],
    *,
    decimals: int = 3,
    planar: bool = False,
    one_sided: bool = False,
    seed: int = SEED,
) -> Instance:
    """Return a random instance with at least one real pose.

    Parameters
    ----------
    pattern
        A type, all primitives distinct, or which constraints share which primitives.
    decimals
        With how many decimals numbers are written.
    planar
        Whether the points of each body lie in one plane.
    one_sided
        Whether one side of each DPH and DHP is stated, not both.
    seed
        The same seed gives the same instance.

    Raises
    ------
    GspError
        If the pattern can never fix the platform, or no well-conditioned pose was found.
    """
    rng = np.random.default_rng(seed)
    made, _ = random_instance(pattern, rng, digits=decimals, planar=planar, one_sided=one_sided)
    return made
