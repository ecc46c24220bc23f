"""Proof that a branch follows a chord while all coefficients of the equations move.

The theorem is that of native/segment_proof.hpp. There only the values move and the quadrics are
constant; here the quadrics are polynomials in tau with bounded remainders
(`gspcli.certification.branches.taylor`). This program is independent of the native one and takes
any number of branches at a time; where only values move the two can be compared.

The theorem holds in any norm. Near singular poses, and where a mode goes far away, the mode moves
mainly along n, the singular direction with the smallest singular value. The Euclidean norm counts
derivatives in all other directions as if the mode moved in them, too. So if a proof fails in this
norm, other norms are tried: those of y for points ``z + B y``. The columns of B are the singular
directions, each times a power of its singular value relative to that of n. These norms use the
second derivatives themselves and not only bounds of their sizes, which are large in other
directions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.chord_residuals import ExactChords
from gspcli.motion.following.chord_bends import Bends
from gspcli.motion.following.chord_equations import (
    BENDS,
    REACH,
    ROUNDING,
    SLOPES,
    VALUES,
    Chord,
    Parts,
)
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: As in native/segment_proof.hpp.
LONGEST = 0.5
_NORM = 1.07
#: The most that bounds at a greater distance from a chord may add to a measure.
_SPARE = 0.005
_OUTWARD = 1 + 2.0**-30
#: Singular values below this part of the largest are taken for zero.
_SINGULAR = 2.0**-200
#: Rounding error of the inverse times p: sums of eight products.
PATCH = 2.0**-49
#: A proof with a measure below this is good enough.
EASY = 0.35
#: The powers of singular values that are tried.
EXPONENTS = (0.0, 0.3, 0.5, 0.7, 0.85, 1.0)


@dataclass(frozen=True, eq=False)
class ChordProofs:
    """Proofs of n chords.

    Attributes
    ----------
    measure
        The measure; a chord is proved if it is below one.
    end
        A bound of the distances of the zeros at both ends from the points.
    uniqueness
        There is no other zero within this distance from the chord.
    radius
        A bound of the distance of the zeros from the chord, all along.
    """

    measure: Array
    end: Array
    uniqueness: Array
    radius: Array

    def joined(self, other: ChordProofs) -> ChordProofs:
        """Return the better numbers of two proofs; if their balls overlap the zeros are the same.

        If the balls do not overlap, return the proof with the smaller measure.
        """
        mine = self.measure <= other.measure
        end = np.minimum(self.end, other.end)
        both = np.maximum(self.measure, other.measure) < 1
        both &= end < np.minimum(self.uniqueness, other.uniqueness)

        def chosen(one: Array, two: Array, together: Array) -> Array:
            return np.where(both, together, np.where(mine, one, two))

        return ChordProofs(
            np.where(mine, self.measure, other.measure),
            chosen(self.end, other.end, end),
            chosen(
                self.uniqueness, other.uniqueness, np.maximum(self.uniqueness, other.uniqueness)
            ),
            chosen(self.radius, other.radius, np.minimum(self.radius, other.radius)),
        )


def prove(
    parts: Parts, first: Array, last: Array, exact: Sequence[ExactChords] | None = None
) -> ChordProofs:
    """Try to prove that branches follow chords.

    Parameters
    ----------
    parts
        The equations.
    first, last
        The ends, Study points of norm about one, shape (n, 8).
    exact
        The equations in balls, for modes that are very near to each other; all norms are tried
        then.
    """
    patch, z, d = on_patch(first, last)
    chord = Chord(parts, z, d)
    for k, one in enumerate(exact or ()):
        chord.values[k], chord.value_errors[k] = one.residuals(z[k], d[k], VALUES)
    matrix = np.concatenate((chord.slopes[:, :, 0], patch[:, None]), axis=1)
    # The numbers of a singular matrix prove nothing.
    with np.errstate(all="ignore"):
        found = _prove_in(chord, matrix, np.broadcast_to(np.eye(8), matrix.shape), None)
        if exact is None or (found.measure < EASY).all() or not np.isfinite(matrix).all():
            return found
        bends = Bends(parts, chord)
        _, sizes, right = np.linalg.svd(matrix)
        # A singular matrix has no weights.
        if not (sizes[:, -1] > _SINGULAR * sizes[:, 0]).all():
            return found
        for exponent in EXPONENTS:
            weights = (sizes[:, -1:] / sizes) ** exponent
            frame = np.swapaxes(right, 1, 2) * weights[:, None]
            found = found.joined(_prove_in(chord, matrix, frame, bends))
            if (found.measure < EASY).all():
                break
    return found


def on_patch(first: Array, last: Array) -> tuple[Array, Array, Array]:
    """Return a patch p for each chord, its middle and its direction, all of shape (n, 8).

    The chord is ``z + tau d``, tau from -1/2 to 1/2, with ``p.z = 1`` and ``p.d = 0`` up to
    rounding. The proofs are about the zeros x with ``p.x = p.(z + tau d)``, exactly.
    """
    patch = first + last
    patch = patch / np.linalg.norm(patch, axis=1, keepdims=True)
    x, y = (z / np.sum(patch * z, axis=1, keepdims=True) for z in (first, last))
    return patch, (x + y) / 2, y - x


def _prove_in(chord: Chord, middle: Array, frame: Array, bends: Bends | None) -> ChordProofs:
    """Try to prove that branches follow chords, in the coordinates y of points ``z + B y``.

    Parameters
    ----------
    chord
        The equations along the chords.
    middle
        Their derivatives in the middle, with p, shape (n, 8, 8).
    frame
        The matrices B, shape (n, 8, 8).
    bends
        Second derivatives; if None, only their sizes are used.
    """
    z, d, patch = chord.z, chord.d, middle[:, 7]
    matrix = middle @ frame
    regular = np.abs(np.linalg.det(matrix)) > 0
    inverse = np.linalg.inv(np.where(regular[:, None, None], matrix, np.eye(8)))
    # Bounds of |x| / |y| and of |y| / |x|.
    longer = np.linalg.norm(frame, ord=2, axis=(1, 2)) * _OUTWARD
    back = np.linalg.inv(frame)
    off = np.linalg.norm(back @ frame - np.eye(8), axis=(1, 2))
    shorter = np.linalg.norm(back, ord=2, axis=(1, 2)) / (1 - off) * _OUTWARD
    sizes = np.linalg.norm(inverse, axis=1)
    q = np.linalg.norm(inverse @ matrix - np.eye(8), axis=(1, 2))
    inner, size = inverse[:, :, :7], sizes[:, :7]
    moved = np.einsum("nxr,nrdy->ndxy", inner, chord.slopes[:, :, 1:]) @ frame[:, None]
    # The first derivatives, in the spectral norm.
    norms = np.linalg.norm(moved, axis=(2, 3))
    q += 0.5 * np.linalg.norm(moved[:, 0], ord=2, axis=(1, 2)) + ROUNDING * norms[:, 0]
    q += norms[:, 1:] @ 0.5 ** np.arange(2, SLOPES)
    q += (np.sum(size * chord.slope_errors, axis=1) + sizes[:, 7] * PATCH) * longer
    constant, linear, rest = _split(chord.values)
    # The residuals at the ends, in the directions in which the inverse is large and in the others.
    shifts = np.stack([np.einsum("nxr,nr->nx", inner, part) for part in (constant, linear)])
    lost = chord.value_errors + ROUNDING * (np.abs(chord.values) @ 0.5 ** np.arange(VALUES))
    end = np.linalg.norm(shifts, axis=2).T @ (1.0, 0.5) + np.sum(size * lost, axis=1)
    bent = np.linalg.norm(np.einsum("nxr,nrd->ndx", inner, rest), axis=2) @ _WEIGHTS
    beta, q, end = (end + bent) * _OUTWARD, q * _OUTWARD, end * _OUTWARD
    left = 1 - q
    radius = 2 * beta / left * _OUTWARD
    if bends is None:
        kappa, reach = np.sum(size * chord.curvatures, axis=1), REACH
    else:
        along, third = _second_and_third(inner, frame, bends)
        # The distance grows while the measure grows little: a larger distance is better for
        # uniqueness.
        far = np.fmin(np.sqrt(left / third), _SPARE / (third * beta))
        reach = np.clip(np.fmax(along / third, far), 4 * radius * longer, REACH)
        kappa = along + third * reach
    kappa = kappa * longer**2 * _OUTWARD
    measure = (q + np.sqrt(2 * kappa * beta)) * _OUTWARD
    uniqueness = np.minimum(left / kappa, reach / longer) / _OUTWARD
    e, de = np.linalg.norm(z[:, :4], axis=1), np.linalg.norm(d[:, :4], axis=1)
    good = regular & (off < 0.5) & (measure < 1) & (radius < reach / longer)
    good &= (np.linalg.norm(d, axis=1) < LONGEST) & (np.linalg.norm(z, axis=1) < _NORM)
    good &= (np.sum(patch * z, axis=1) > 0.9) & (e - de / 2 > radius * longer * _OUTWARD)
    measure = np.where(good, measure, np.fmax(measure, 2.0))
    return ChordProofs(
        np.where(np.isnan(measure), np.inf, measure),
        2 * end / left * longer * _OUTWARD,
        np.where(good, uniqueness / shorter, 0.0),
        np.where(good, radius * longer * _OUTWARD, np.inf),
    )


def _second_and_third(inner: Array, frame: Array, bends: Bends) -> tuple[Array, Array]:
    """Bound the inverse times second and third derivatives in units of y and of x, (n,) each.

    Second derivatives are bounded on the chord, third ones within `REACH` of it.
    """
    size = np.linalg.norm(inner, axis=1)
    moved = np.einsum("nyr,nrdij->ndyij", inner, bends.values)
    moved = np.swapaxes(frame, 1, 2)[:, None, None] @ moved @ frame[:, None, None]
    norms = np.sqrt((moved**2).sum(axis=(2, 3, 4)))
    # The second derivatives, component by component, in the spectral norm.
    spectral = np.abs(np.linalg.eigvalsh(moved[:, 0])).max(axis=2)
    second = np.linalg.norm(spectral, axis=1) + ROUNDING * norms[:, 0]
    second += norms[:, 1:] @ 0.5 ** np.arange(1, BENDS) + np.sum(size * bends.errors, axis=1)
    return second, np.sum(size * bends.thirds, axis=1)


#: Maxima of (1/4 - tau^2) |tau|^j, rounded up.
_WEIGHTS = np.array(
    [0.5 / (j + 2) * (j / (4 * (j + 2))) ** (j / 2) * (1 + 1e-12) for j in range(VALUES - 2)]
)


def _split(values: Array) -> tuple[Array, Array, Array]:
    """Return r0, r1 and G with ``F = r0 + r1 tau + (tau^2 - 1/4) G``."""
    rest = values[..., 2:].copy()
    for j in range(rest.shape[-1] - 3, -1, -1):
        rest[..., j] += 0.25 * rest[..., j + 2]
    return values[..., 0] + 0.25 * rest[..., 0], values[..., 1] + 0.25 * rest[..., 1], rest
