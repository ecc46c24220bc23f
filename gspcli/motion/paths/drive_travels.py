"""How far drives move while position and angles change along a straight way, proved.

All vectors are enclosed as functions of one parameter of the way, by plain formulas.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.enclosures import Enclosure, joined, size
from gspcli.motion.paths.pose_ways import PoseWays

Array = NDArray[np.float64]

#: Parts of a way.
_PARTS = 16
_AXES = np.eye(3)


def drive_travels(ways: PoseWays, begins: Array, ends: Array) -> Array:
    """Bound how far drives move on straight ways in position and angles, shape (n, m).

    Lengths and radians; infinite where nothing is proved.

    Parameters
    ----------
    ways
        The platform, with its drives on their knees.
    begins, ends
        Parameters of poses, shape (n, 6).
    """
    half = (ends - begins) / (2 * _PARTS)
    middles = begins[:, None] + (2 * np.arange(_PARTS)[:, None] + 1) * half[:, None]
    far = np.repeat(size(begins) + size(ends), _PARTS)
    near = _Vectors(ways, middles.reshape(-1, 6), np.repeat(half, _PARTS, axis=0), far)
    with np.errstate(all="ignore"):
        found = near.moves().reshape(len(half), _PARTS, -1)
    # From one end of a part to the other it is at most twice as far as from the middle.
    return np.asarray(2 * found.sum(axis=1))


class _Vectors:
    """The vectors of a platform on parts of ways, enclosed.

    Middles and half changes have shape (n, 6), sizes of all parameters (n,).
    """

    def __init__(self, ways: PoseWays, middles: Array, halves: Array, far: Array) -> None:
        self.ways, self.arrangement = ways, Arrangement.of(ways.instance)
        rad = Enclosure.rounded(middles, far).rad
        self.place = Enclosure(middles[:, :3], rad, halves[:, :3, None])
        angles = [
            Enclosure(middles[:, k : k + 1], rad, halves[:, k : k + 1, None]) for k in (3, 4, 5)
        ]
        self.turns = [(one.cos(), one.sin()) for one in angles]
        sequence = ways.boxes.sequence
        letters = sequence if sequence.isupper() else sequence[::-1]
        self.axes = ["xyz".index(letter) for letter in letters.lower()]
        self.count = len(middles)

    def fixed(self, vector: Array) -> Enclosure:
        return Enclosure.rounded(np.broadcast_to(vector, (self.count, 3)))

    def turned(self, x: Enclosure, *, back: bool = False) -> Enclosure:
        """Return vectors turned from the platform to the base, or back."""
        for axis in self.axes if back else self.axes[::-1]:
            cos, sin = self.turns[axis]
            along = np.outer(_AXES[axis], _AXES[axis])
            across = np.cross(_AXES[axis], _AXES).T * (-1.0 if back else 1.0)
            x = x.under(along) + x.under(np.eye(3) - along) * cos + x.under(across) * sin
        return x

    def moves(self) -> Array:
        """Bound how far each drive moves from where it is in the middle, shape (n, m)."""
        motors = self.ways.motors
        if motors is None:
            columns = [self._of_value(k) for k in range(6)]
        else:
            drives = motors.drives
            drives.refuse_planes("how far drives move on a path")
            first = [drives.users(k)[0] for k in range(drives.count)]
            columns = [self._of_drive(k) if drives.driven[k] else self._of_value(k) for k in first]
        return np.stack(columns, axis=1)

    def _of_value(self, k: int) -> Array:
        a = self.arrangement
        kind = a.kinds[k]
        w, v = self.turned(self.fixed(a.u[k])), self.fixed(a.v[k])
        if not kind.is_distance:
            return _angle(w)
        r = self.place + self.turned(self.fixed(a.y[k] - self.ways.pivot)) - self.fixed(a.x[k])
        if kind is DLL:
            normal = w.cross(v)
            return _moved(r.dot(normal) * normal.norm().inverse())
        if kind in (DPH, DHP):
            return _moved(r.dot(v if kind is DPH else w))
        across = {DPP: r, DPL: r.cross(v), DLP: r.cross(w)}[kind]
        return _moved(across.norm())

    def _of_drive(self, k: int) -> Array:
        """Bound how far a crank turns, or a slide moves."""
        motors, a = self.ways.motors, self.arrangement
        assert motors is not None
        drives, knee = motors.drives, float(motors.knees[k])
        if drives.on_platform[k]:
            away = self.fixed(a.x[k]) - self.place
            other = self.turned(away, back=True) + self.fixed(self.ways.pivot)
        else:
            other = self.place + self.turned(self.fixed(a.y[k] - self.ways.pivot))
        w = other - self.fixed(drives.middle[k])
        along, beside = w.dot(self.fixed(drives.across[k])), w.dot(self.fixed(drives.beside[k]))
        rod, square = self._number(drives.rods[k]), w.dot(w)
        if drives.sorts[drives.index[k]] == "slide":
            return _moved(beside - knee * (rod * rod - square + beside * beside).sqrt())
        # The angle between w, in the plane of the crank, and the arm; both as unit vectors.
        arm, both = self._number(drives.arms[k]), joined(along, beside)
        far = both.norm()
        cosine = 0.5 * ((square + arm * arm - rod * rod) * far.inverse())
        sine = (self._number(1.0) - cosine * cosine).sqrt()
        direction, left = both.unit(), joined(beside, -along).unit()
        return _angle(direction * cosine + knee * (left * sine))

    def _number(self, value: float) -> Enclosure:
        return Enclosure.rounded(np.full((self.count, 1), value))


def _moved(x: Enclosure) -> Array:
    """Bound how far vectors move from where they are in the middle."""
    return np.asarray(x.slope + 2 * x.rad)


def _angle(unit: Enclosure) -> Array:
    """Bound by which angles unit vectors turn from where they are in the middle."""
    chord = _moved(unit)
    return np.where(chord < 2, 2 * np.arcsin(np.minimum(chord / 2, 1.0)), np.inf)
