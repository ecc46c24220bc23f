"""In which conventions a log may be written: order and sense of angles, units."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.logs import Log
from gspcli.geometry.euler import rotation_from_euler
from gspcli.records import dataclass
from gspcli.wording import listed

Array = NDArray[np.float64]

#: Orders of the axes, about the axes of the platform; usual ones first. Those about the axes of the
#: base are the same, written backwards.
ORDERS = ("ZYX", "XYZ", "ZXY", "YXZ", "XZY", "YZX")
#: About which axes the three columns turn: as named, in reverse (A B C of KUKA), the others.
_AXES = ((0, 1, 2), (2, 1, 0), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1))
_SENSES = tuple((x, y, z) for x, y, z in product((1, -1), repeat=3))
#: How long a unit of positions is in units of lengths of legs, and what these units may be.
FACTORS = {
    1.0: ("", ""),
    1000.0: ("mm", "m"),
    1e-3: ("m", "mm"),
    10.0: ("mm", "cm"),
    0.1: ("cm", "mm"),
    100.0: ("cm", "m"),
    1e-2: ("m", "cm"),
    25.4: ("mm", "in"),
    1 / 25.4: ("in", "mm"),
}
_DEGREE = float(np.pi / 180)


@dataclass(frozen=True)
class Turns:
    """A convention of rotations.

    Attributes
    ----------
    order
        The order of the axes of angles, about those of the platform; empty for whole rotations.
    senses
        Of the angles about x, y and z: 1, or -1 for the opposite of the right-hand rule.
    in_radians
        The unit of angles.
    transposed
        Whether rotations are from the base's frame to the platform's.
    axes
        About which axis the angle of each column turns, 0 to 2 for x to z.
    heads
        The headings of these columns if they do not name axes, such as ``A``; empty otherwise.
    unit
        The unit of angles in the log, ``deg`` or ``rad``.
    """

    order: str = ""
    senses: tuple[int, int, int] = (1, 1, 1)
    in_radians: float = 1.0
    transposed: bool = False
    axes: tuple[int, int, int] = (0, 1, 2)
    heads: tuple[str, ...] = ()
    unit: str = ""

    def rotations(self, log: Log, rows: NDArray[np.intp]) -> Array:
        """Return the rotations of some rows of a log, shape (n, 3, 3)."""
        if log.rotations is not None:
            found = log.rotations[rows]
            return np.swapaxes(found, 1, 2) if self.transposed else found
        assert log.angles is not None
        turned = np.empty((len(rows), 3))
        turned[:, self.axes] = log.angles[rows]
        turned *= np.array(self.senses) * self.in_radians
        return rotation_from_euler(self.order, turned)

    @property
    def unusual(self) -> int:
        """How many senses are not those of the right-hand rule, and axes not in order."""
        return self.senses.count(-1) + self.transposed + (self.axes != (0, 1, 2))

    def words(self, *, unit: bool = True) -> str:
        """Return the convention in words."""
        if not self.order:
            how = "base to platform (transposed)" if self.transposed else "platform to base"
            return f"rotations from {how}"
        names = ("rx", "ry", "rz")
        wrong = [name for name, one in zip(names, self.senses, strict=True) if one < 0]
        of = "degrees" if self.unit == "deg" else "radians"
        said = f"--euler {self.order}"
        said += f", {of}" if unit else ""
        if self.axes != (0, 1, 2):
            there = " ".join("xyz"[axis] for axis in self.axes)
            said += f", {' '.join(self.heads)} about {there}"
        return f"{said}, {listed(wrong, 'and')} left-handed" if wrong else said


def turns_of(log: Log, euler: str | None) -> Iterator[Turns]:
    """Yield the conventions that rotations of a log may have.

    Parameters
    ----------
    log
        The log.
    euler
        The order of the axes if it is known, as `rotation_from_euler` takes it; angles then follow
        the right-hand rule.
    """
    if log.rotations is not None:
        yield Turns()
        yield Turns(transposed=True)
        return
    units = (1.0,) if log.angle_unit else (_DEGREE, 1.0)
    orders: tuple[str, ...] = ORDERS
    senses = _SENSES
    if euler is not None:
        orders = (euler if euler.isupper() else euler[::-1].upper(),)
        senses = ((1, 1, 1),)
    elif log.order is not None:
        orders = tuple(dict.fromkeys((log.order, *ORDERS)))
    for unit, axes, order, sense in product(
        units, _AXES if log.heads else _AXES[:1], orders, senses
    ):
        said = log.angle_unit or ("rad" if unit == 1 else "deg")
        yield Turns(order, sense, unit, axes=axes, heads=log.heads, unit=said)
