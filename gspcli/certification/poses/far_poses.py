"""Poses far away, proved for other values of a geometry from poses that are known, without paths.

A platform that is special up to the rounding of its numbers, by eps, has poses eps^-2 lengths away,
where N is eps^4. A value enters its equation as a multiple of N alone: so these poses hardly depend
on the values. In local coordinates at a known one (native/far_poses.hpp) the equations for other
values have coefficients of order one, whatever N is, and doubles prove what takes hundreds of bits
in the frames of the platform. The coefficients are computed in balls from the equations of
`ball_system`; the theorem is that of `isolation`, and what is proved is rounded correctly.
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

#: Part of its size by which a difference of two values in 32 digits errs.
_DIFFERENCE = 2.0**-100


@dataclass(frozen=True, eq=False)
class FarPoses:
    """Poses far away of a platform, from which those for other values are proved.

    Attributes
    ----------
    numbers
        What the kernel has of each (native/far_poses.hpp), in two parts, shape (2, n, 752).
    errors
        By how much they err, shape (n,).
    real
        Which of the poses are real, shape (n,); of a pair of conjugates one is here.
    values
        The values as the kernel wants them (`ValueProofs.own_values`), shape (6, 6).
    powers
        Of lengths that values are in their equations, shape (6,).
    scale
        The unit of length.
    approached
        How many, the last, are found only from approximations for the same values.
    centres
        Study points of the poses in that unit, with one as the largest coordinate of e, (n, 8).
    slopes
        What takes differences from them to local coordinates, shape (n, 7, 8).
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
        """Return the poses of a platform that are known; None if some are not known well enough.

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
        # Those that need to be approached are the last.
        known.sort(key=lambda each: each.is_bent)
        kinds = proofs.kinds
        return cls(
            numbers=np.ascontiguousarray(np.stack([each.numbers for each in known], axis=1)),
            errors=np.array([each.error for each in known]),
            real=np.array([each.real for each in known], np.uint8),
            values=proofs.own_values(choice[None])[0],
            powers=np.array([2 * k.is_distance - k.has_sides for k in kinds]),
            scale=locator.scale,
            approached=sum(each.is_bent for each in known),
            centres=np.array([each.centre for each in known]),
            slopes=np.array([each.slope for each in known]),
        )

    def __len__(self) -> int:
        """Return how many poses there are, conjugates included."""
        return 2 * len(self.real) - int(self.real.sum())

    @property
    def points(self) -> tuple[Complex, Complex]:
        """R (k, 3, 3) and T (k, 3) of those, in the frames of the instance."""
        chosen = self.centres[len(self.centres) - self.approached :]
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
            As the kernel wants them (`ValueProofs`), of one choice of sides, shape (b, 6, 6).
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
        """Return poses for the same values with these beside them; parameters as for `decide`."""
        far = self.decide(values, units, scale, local, jobs=jobs)
        # What is larger is another pose.
        with np.errstate(invalid="ignore"):
            least = (_largest(far.R, far.T / scale) - far.deviation).min(axis=1)
            largest = (_largest(near.R, near.T / scale) + near.deviation).max(axis=1, initial=0)
        complete = near.complete & far.complete & (largest * OUTWARD < least)
        parts = (np.concatenate(both, axis=1) for both in zip(near[:-1], far[:-1], strict=True))
        return ProvedPoses._make([*parts, complete])

    def _shifts(self, values: Array, ratio: float) -> Array:
        """Return by how much values are greater than those of the platform, (b, 3, 6)."""
        # Exact: powers of two.
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
    """Return the real poses and one of each pair of conjugates; None if some have no partner."""
    entries = np.concatenate((R.reshape(-1, 9), T), axis=1) + 0.0
    places = {row.tobytes(): k for k, row in enumerate(entries)}
    partners = [places.get((row.conj() + 0.0).tobytes(), -1) for row in entries]
    if min(partners, default=0) < 0:
        return None
    return [k for k, partner in enumerate(partners) if k <= partner]
