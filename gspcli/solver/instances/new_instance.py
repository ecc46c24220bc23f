"""A random instance to start from."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from gspcli.catalogue.aliases import find_alias
from gspcli.catalogue.coincidence import Bond, parse_sharing
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import GspType
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.solver.instances.generate import random_instance

_BOND = re.compile(r"[PLH]\d+[-^][plh]\d+")


def new(
    pattern: GspType | Sequence[Bond] | str | int,
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
        A type, its name or its number, all primitives distinct; or which constraints share which
        primitives, as bonds or as a text such as ``P1-p1 P1-p2 P2-p3 P2-p4 P3-p5 P3-p6``.
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
    if isinstance(pattern, str | int):
        pattern = _named(str(pattern))
    rng = np.random.default_rng(seed)
    made, _ = random_instance(pattern, rng, digits=decimals, planar=planar, one_sided=one_sided)
    return made


def _named(text: str) -> GspType | Sequence[Bond]:
    """Return the type or the shared primitives that a text names."""
    alias = find_alias(text)
    if (alias and alias.pattern) or any(map(_BOND.fullmatch, text.split())):
        return parse_sharing(text).bonds
    return parse_type(text)
