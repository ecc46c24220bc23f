"""Which real pose is home: the one nearest to the stated home, or the least turned.

Poses are compared by one metric: the translation of the platform's origin and the angle of the
turn times the platform's size, the root of the sum of their squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gspcli.geometry.arrangement import Arrangement, Array
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import vector_from_rotation
from gspcli.records import EqualByContent, dataclass

#: Poses whose distances differ by less, in the platform's size, are equally near.
_EQUAL = 1e-6
#: A stated home that is farther from every mode, in the platform's size, is probably a mistake.
_FAR = 0.1


@dataclass(frozen=True, eq=False)
class HomeMode(EqualByContent):
    """The real pose that is meant where a command needs one."""

    #: Its number among the real poses, from 1, as `gsp solve` lists them.
    number: int
    #: The pose, shapes (3, 3) and (3,).
    R: Array
    T: Array
    #: How many real poses there are.
    count: int
    #: Whether the instance states a home; else it is the least turned pose.
    stated: bool
    #: How many are equally near: of those it is the highest.
    equal: int
    #: How far it is from the stated home, in words; empty if that is where it is.
    away: str
    #: Whether only some of the real poses were kept, of which there are `count`.
    kept: bool = False
    #: What is odd if it is far from the stated home, else empty.
    doubt: str = ""

    @property
    def reason(self) -> str:
        """Why it is this one, in words."""
        if self.count == 1:
            return "the only real pose" + (" that is kept" if self.kept else "")
        what = "nearest to the stated home"
        if not self.stated:
            which = "kept" if self.kept else "real"
            what = f"the least turned of {self.count} {which} poses (no home is stated)"
        if self.away:
            what += f", {self.away} from it"
        return what + (f", the highest of {self.equal} alike" if self.equal > 1 else "")

    def to_json(self) -> dict[str, Any]:
        """Return which mode it is as plain data."""
        return {"mode": self.number, "stated": self.stated, "reason": self.reason}

    @property
    def text(self) -> str:
        """Which mode it is and why, in words."""
        return f"home is mode {self.number}: {self.reason}"


def home_among(instance: Instance, R: Array, T: Array, kept: Sequence[int]) -> HomeMode | None:
    """Return which of some real poses is home, as `home_mode`; `kept` has their indices."""
    chosen = list(kept)
    found = home_mode(instance, R[chosen], T[chosen])
    if found is None:
        return None
    return replace(found, number=chosen[found.number - 1] + 1, kept=len(chosen) < len(R))


def home_mode(instance: Instance, R: Array, T: Array) -> HomeMode | None:
    """Return which of the real poses of a platform is home; None if there are none.

    Parameters
    ----------
    instance
        The platform, with or without a stated home.
    R, T
        The real poses, shapes (n, 3, 3) and (n, 3).
    """
    if not len(R):
        return None
    arrangement, home = Arrangement.of(instance), instance.home
    if home is None:
        moved, turned = np.zeros(len(R)), distances(R, T, np.eye(3), np.zeros(3))[1]
    else:
        moved, turned = distances(R, T, home.R(arrangement.in_radians), home.T)
    apart = np.hypot(moved / arrangement.length, turned)
    equal = np.flatnonzero(apart <= apart.min() + _EQUAL)
    middles = R[equal] @ arrangement.platform_centre + T[equal]
    # Heights that differ by rounding errors are equal, and the first of them counts.
    best = int(equal[(middles[:, 2] / arrangement.length).round(6).argmax()])
    away = doubt = ""
    if home is not None and apart[best] > _EQUAL:
        units = instance.units
        turn = turned[best] / arrangement.in_radians
        away = f"{moved[best]:.3g} {units.length} and {turn:.3g} {units.angle.value}"
        if apart[best] > _FAR:
            doubt = (
                f"the stated home is {away} from the nearest mode, more than a tenth of the "
                f"platform: are its numbers in {units.length} and {units.angle.value}, and are the "
                "values those at home?"
            )
    return HomeMode(
        best + 1, R[best], T[best], len(R), home is not None, len(equal), away, doubt=doubt
    )


def distances(R: Array, T: Array, R0: Array, T0: Array) -> tuple[Array, Array]:
    """Return how far poses are from another one: the translations and the turns, shapes (n,).

    Parameters
    ----------
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    R0, T0
        The other pose, shapes (3, 3) and (3,).
    """
    turned = np.linalg.norm(vector_from_rotation(R @ R0.T), axis=1)
    return np.linalg.norm(T - T0, axis=1), turned
