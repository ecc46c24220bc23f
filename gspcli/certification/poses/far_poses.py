"""Poses far away, proved for other values of a geometry from poses that are known, without paths.

A platform that is special up to the rounding eps of its numbers has poses eps^-2 lengths away, with
N of size eps^4. A value occurs in its equation only as a multiple of N, so these poses hardly
depend on the values. In local coordinates at a known pose (native/far_poses.hpp) the equations for
other values have coefficients of order one for any N. There doubles suffice for proofs that need
hundreds of bits in the frames of the platform. The coefficients are computed in balls from the
equations of `ball_system`. The theorem is that of `isolation`, and proved poses are rounded
correctly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.certification.equations.frames import Frames
from gspcli.certification.numbers.doubled import two_sum
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.certification.poses.local_coordinates import local_coordinates
from gspcli.certification.poses.locator import Locator
from gspcli.certification.poses.many_values import ProvedPoses, ValueProofs, proved_bits
from gspcli.defaults import TOLERANCE
from gspcli.geometry.quaternions import pose_from_study, quaternion_product
from gspcli.records import dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Relative error of a difference of two values with 32 digits.
_DIFFERENCE = 2.0**-100


@dataclass(frozen=True, eq=False)
class FarPoses:
    """Poses of a platform far away, from which the poses for other values are proved.

    Attributes
    ----------
    numbers
        The numbers of each pose for the kernel (native/far_poses.hpp), as two doubles each, shape
        (2, n, 752).
    errors
        Bounds of their errors, shape (n,).
    real
        Which of the poses are real, shape (n,); a pair of conjugates is stored as one pose.
    values
        The values in the form of the kernel (`ValueProofs.values`), shape (6, 6).
    powers
        The power of a length that each value is in its equation, shape (6,).
    scale
        The unit of length.
    approached
        The number of poses, the last ones, that need approximations for the same values.
    centres
        Study points of the poses in that unit, with one as the largest coordinate of e, (n, 8).
    slopes
        The matrices that convert differences from the centres to local coordinates, shape (n, 7,
        8).
    """

    numbers: Complex
    errors: Array
    real: NDArray[np.uint8]
    values: Array
    powers: NDArray[np.int64]
    scale: float
    approached: int
    centres: Complex
    slopes: Complex

    @classmethod
    def of(
        cls,
        locator: Locator,
        proofs: ValueProofs,
        choice: Array,
        sides: tuple[int, ...],
        R: Complex,
        T: Complex,
    ) -> FarPoses | None:
        """Return the known poses of a platform; None if some are not accurate enough.

        Parameters
        ----------
        locator, proofs
            The equations of the platform.
        choice, sides
            The sides of its values, and the indices of its equations (`Problem`).
        R, T
            The poses, rounded correctly, shapes (n, 3, 3) and (n, 3).
        """
        chosen = _one_of_each_pair(R, T)
        if chosen is None:
            return None
        found = [local_coordinates(locator, sides, R[k], T[k]) for k in chosen]
        known = [each for each in found if each is not None]
        if len(known) < len(found) or not known:
            return None
        # Poses that need approximations are the last.
        known.sort(key=lambda each: each.is_bent)
        kinds = proofs.kinds
        return cls(
            numbers=np.ascontiguousarray(np.stack([each.numbers for each in known], axis=1)),
            errors=np.array([each.error for each in known]),
            real=np.array([each.real for each in known], np.uint8),
            values=proofs.values(choice[None])[0, 0],
            powers=np.array([2 * k.is_distance - k.has_sides for k in kinds]),
            scale=locator.scale,
            approached=sum(each.is_bent for each in known),
            centres=np.array([each.centre for each in known]),
            slopes=np.array([each.slope for each in known]),
        )

    def __len__(self) -> int:
        """Return the number of poses, conjugates included."""
        return 2 * len(self.real) - int(self.real.sum())

    @property
    def points(self) -> tuple[Complex, Complex]:
        """R (k, 3, 3) and T (k, 3) of the poses, in the frames of the instance.

        They are not finite where doubles do not tell a pose from a point with N = 0.
        """
        chosen = self.centres[len(self.centres) - self.approached :]
        with np.errstate(all="ignore"):
            R, T = pose_from_study(chosen[:, :4], chosen[:, 4:])
        return np.asarray(R, np.complex128), np.asarray(T * self.scale, np.complex128)

    def local(self, points: Complex, frames: Frames) -> Complex:
        """Return local coordinates, (b, n, 7), with those of approximations of the last k poses.

        Parameters
        ----------
        points, frames
            Study points of any norm, shape (b, k, 8), and their frames.
        """
        found = np.zeros((len(points), len(self.real), 7), complex)
        if not points.shape[1]:
            return found
        e = points[..., :4]
        base, platform = (np.array([0, *x], complex) for x in (frames.base, frames.platform))
        across = quaternion_product(base, e) - quaternion_product(e, platform)
        f = (frames.length * points[..., 4:] + across / 2) / self.scale
        place = slice(len(self.real) - points.shape[1], None)
        centres, slopes = self.centres[place], self.slopes[place]
        patches = np.abs(centres[:, :4]).argmax(axis=1)
        with np.errstate(all="ignore"):
            whole = np.concatenate((e, f), axis=-1)
            whole /= whole[:, np.arange(len(patches)), patches][..., None]
            found[:, place] = (slopes @ (whole - centres)[..., None])[..., 0]
        return found

    def decide(
        self,
        values: Array,
        units: Array,
        scale: float,
        local: Complex | None = None,
        *,
        jobs: int = 1,
    ) -> ProvedPoses:
        """Prove the poses for other values of the geometry.

        Parameters
        ----------
        values
            Values in the form of the kernel (`ValueProofs`), of one choice of sides, shape (b, 6,
            6).
        units
            The units of the last digits of translations, in `scale`, shape (b,).
        scale
            The unit of length of these values.
        local
            Approximations (`local`); by default the poses that are known.
        jobs
            Threads.
        """
        blank = np.zeros((len(values), len(self.real), 7), complex)
        R, T, quaternions, off, bits, complete = _kernel.decide_far(
            self.numbers,
            self.errors,
            self.real,
            self._shifts(values, scale / self.scale),
            blank if local is None else local,
            units * (scale / self.scale),
            scale=self.scale,
            tolerance=TOLERANCE,
            jobs=jobs,
        )
        certified, real, rounded = proved_bits(bits)
        return ProvedPoses(
            R=R,
            T=T,
            quaternions=quaternions,
            certified=certified,
            real=real,
            rounded=rounded,
            # In units of the other equations.
            deviation=off * max(self.scale / scale, 1.0),
            complete=complete > 0,
        )

    def beside(
        self,
        near: ProvedPoses,
        values: Array,
        units: Array,
        scale: float,
        local: Complex | None,
        *,
        jobs: int = 1,
    ) -> ProvedPoses:
        """Return near poses and the far ones for the same values; parameters as for `decide`."""
        far = self.decide(values, units, scale, local, jobs=jobs)
        # Two poses are different if their error bounds do not overlap.
        with np.errstate(invalid="ignore"):
            least = (_largest(far.R, far.T / scale) - far.deviation).min(axis=1)
            largest = (_largest(near.R, near.T / scale) + near.deviation).max(axis=1, initial=0)
        complete = near.complete & far.complete & (largest * OUTWARD < least)
        parts = (np.concatenate(both, axis=1) for both in zip(near[:-1], far[:-1], strict=True))
        return ProvedPoses._make([*parts, complete])

    def _shifts(self, values: Array, ratio: float) -> Array:
        """Return the differences of values from those of the platform, (b, 3, 6)."""
        # The factors are powers of two and exact.
        factor = ratio ** self.powers.astype(float)
        high, low, gap = (values[:, k] * factor for k in (0, 3, 4))
        own, own_low, own_gap = (self.values[k] for k in (0, 3, 4))
        difference, rest = two_sum(high, np.broadcast_to(-own, high.shape))
        size = np.abs(high) + np.abs(own)
        gaps = OUTWARD * (gap + own_gap + _DIFFERENCE * size)
        return np.ascontiguousarray(np.stack((difference, rest + (low - own_low), gaps), axis=1))


def _largest(R: Complex, T: Complex) -> Array:
    """Return the largest part of an entry of each pose, shape (b, n)."""
    turns, places = (np.abs(x.view(np.float64)).max(axis=-1) for x in (R, T))
    found: Array = np.maximum(turns.max(axis=-1), places)
    return found


def _one_of_each_pair(R: Complex, T: Complex) -> list[int] | None:
    """Return the real poses and one of each conjugate pair; None if a partner is missing."""
    entries = np.concatenate((R.reshape(-1, 9), T), axis=1) + 0.0
    places = {row.tobytes(): k for k, row in enumerate(entries)}
    partners = [places.get((row.conj() + 0.0).tobytes(), -1) for row in entries]
    if min(partners, default=0) < 0:
        return None
    return [k for k, partner in enumerate(partners) if k <= partner]
