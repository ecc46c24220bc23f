"""Mirror images of the poses of legs between two planes.

Reflect both bodies in their planes, z = 0 of their frames: the points stay where they are, and the
rotation R becomes S R S, the translation S T, with S = diag(1, 1, -1). So with each pose there is
its mirror image, which is as long away, real or not. The same holds for the solved platforms where
paths begin.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

#: The signs of Study parameters (e, f), of the entries of R, and of those of T.
STUDY_SIGNS = np.array([1.0, -1, -1, 1, -1, 1, 1, -1])
_TRANSLATION_SIGNS = np.array([1.0, 1, -1])
_ROTATION_SIGNS = np.outer(_TRANSLATION_SIGNS, _TRANSLATION_SIGNS)


def mirrored(points: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the mirror images of Study points (..., 8), or of quaternions (..., 4)."""
    with np.errstate(invalid="ignore"):
        images: NDArray[np.complex128] = points * STUDY_SIGNS[: points.shape[-1]]
    return images


def mirrored_pose(
    R: NDArray[np.complex128], T: NDArray[np.complex128]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return the mirror images of poses, (..., 3, 3) and (..., 3); zero has one sign."""
    with np.errstate(invalid="ignore"):
        return R * _ROTATION_SIGNS + 0.0, T * _TRANSLATION_SIGNS + 0.0


def with_mirror_images(points: NDArray[np.complex128], axis: int = 0) -> NDArray[np.complex128]:
    """Return Study points (..., 8), then along an axis their mirror images."""
    return np.concatenate((points, mirrored(points)), axis=axis)


def has_mirror_images(instance: Instance) -> bool:
    """Whether all constraints are legs, and all points are exactly in the planes z = 0."""
    return all(row.kind is DPP for row in instance.constraints) and all(
        primitive.position[2].fraction == 0 for primitive in instance.primitives
    )
