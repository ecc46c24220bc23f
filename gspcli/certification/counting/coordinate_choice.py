"""The choice of the coordinates of rigid motions with the simplest equations of a platform.

A set contains R, and T or U = R^T T or both; with both it may contain rho = T.T. PH is linear in
(R, T), HP in (R, U), PP in sets with rho. PL needs T, LP needs U; PL, LP and LL are quadrics. A
constraint that is not linear in a set is a quadric in it, except PL without T and LP without U.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntFlag

from gspcli.catalogue.kinds import DHP, DLP, DPH, DPL, DPP, Kind


class Blocks(IntFlag):
    """Blocks of coordinates besides R, with the numbers of the kernel."""

    TRANSLATION = 1
    BODY = 2
    DISTANCE = 4


_T, _U, _RHO = Blocks.TRANSLATION, Blocks.BODY, Blocks.DISTANCE
#: The sets with the degree of their variety (data/varieties.json).
DEGREES: dict[Blocks, int] = {_T: 8, _U: 8, _T | _U: 20, _T | _U | _RHO: 40}
_LINEAR = {DPH: _T, DHP: _U, DPP: _T | _U | _RHO}
_NEEDED = {DPL: _T, DLP: _U}


def quadrics(blocks: Blocks, kinds: Sequence[Kind]) -> int:
    """Return the number of constraints that are quadrics in a set of coordinates."""
    return sum(
        kind.is_distance and (kind not in _LINEAR or _LINEAR[kind] not in blocks) for kind in kinds
    )


def choose(kinds: Sequence[Kind]) -> Blocks:
    """Return the set with the least product of its degree and those of the equations."""
    possible = [
        blocks
        for blocks in DEGREES
        if all(_NEEDED[kind] in blocks for kind in kinds if kind in _NEEDED)
    ]
    return min(possible, key=lambda blocks: DEGREES[blocks] << quadrics(blocks, kinds))
