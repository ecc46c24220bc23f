"""Exact rational instances of each kind of constraint, with rigid motions that satisfy them.

They are built from the geometry only: an offset of the given length perpendicular to the directions
of the two primitives, and a rotation through the given angle. So they are an independent test of
the equations of `tools.equations.constraint_equations`.
"""

from __future__ import annotations

from fractions import Fraction
from random import Random

import numpy as np

from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.records import dataclass
from gspcli.symbolic.exact_motions import (
    Exact,
    RationalMotion,
    cayley,
    random_fraction,
    random_rotation,
    random_vector,
)


@dataclass(frozen=True)
class RationalConstraint:
    """A constraint with rational data.

    Attributes
    ----------
    kind
        The kind of constraint.
    platform_frame, base_frame
        Rotations whose third columns are the unit vectors v and u of the primitives; their other
        columns are the directions v1, v2 and u1, u2 of planes.
    platform_point, base_point
        Y or B, and X or A.
    distance
        The value d > 0 of a distance.
    cosine, sine
        Those of the angle between the vectors v and u at the value of an angle.
    """

    kind: Kind
    platform_frame: Exact
    base_frame: Exact
    platform_point: Exact
    base_point: Exact
    distance: Fraction
    cosine: Fraction
    sine: Fraction

    @property
    def vectors(self) -> dict[str, Exact]:
        """The vectors by the names that the equations use."""
        return {
            "Y": self.platform_point,
            "B": self.platform_point,
            "X": self.base_point,
            "A": self.base_point,
            **{f"v{k}": self.platform_frame[:, int(k) - 1] for k in "12"},
            **{f"u{k}": self.base_frame[:, int(k) - 1] for k in "12"},
            "v": self.platform_frame[:, 2],
            "u": self.base_frame[:, 2],
        }

    def motion(self, random: Random, side: int | None = None) -> RationalMotion:
        """Return a random rational motion that satisfies the constraint.

        Parameters
        ----------
        random
            Source of the motion.
        side
            +1 or -1 for a chosen side of a DPH or DHP; either when None.
        """
        if not self.kind.is_distance:
            return RationalMotion(
                self._at_angle(self.cosine, self.sine, random), random_vector(random)
            )
        if self.kind.platform is self.kind.base is Primitive.LINE:
            cosine, sine = circle_point(random)
            rotation = self._at_angle(cosine, sine, random)
            v, u = rotation @ self.platform_frame[:, 2], self.base_frame[:, 2]
            normal = np.cross(v, u) / sine
            along = random_fraction(random) * v + random_fraction(random) * u
            offset = random.choice((-1, 1)) * self.distance * normal + along
        else:
            rotation = random_rotation(random)
            frame = self.base_frame
            if self.kind.base is Primitive.POINT:
                frame = rotation @ self.platform_frame
            offset = frame @ self._offset(random, side)
        translation = offset - rotation @ self.platform_point + self.base_point
        return RationalMotion(rotation, translation)

    def _at_angle(self, cosine: Fraction, sine: Fraction, random: Random) -> Exact:
        """Return a random rotation that brings v to the given angle with u."""
        zero, one = Fraction(0), Fraction(1)
        turn = np.array(
            [[one, zero, zero], [zero, cosine, -sine], [zero, sine, cosine]], dtype=object
        )
        about = [cayley(zero, zero, random_fraction(random)) for _ in range(2)]
        rotation: Exact = self.base_frame @ about[0] @ turn @ about[1] @ self.platform_frame.T
        return rotation

    def _offset(self, random: Random, side: int | None) -> Exact:
        """Return an offset at the distance from the span of the directions, in their frame."""
        primitives = {self.kind.platform, self.kind.base}
        if Primitive.PLANE in primitives:
            # Positive where the point is on the side of the normal; w leads to the platform.
            sign = side or random.choice((-1, 1))
            height = sign * self.distance * (1 if self.kind.base is Primitive.PLANE else -1)
            return np.array(
                [random_fraction(random), random_fraction(random), height], dtype=object
            )
        if Primitive.LINE in primitives:
            x, y = circle_point(random)
            along = random_fraction(random)
            return np.array([self.distance * x, self.distance * y, along], dtype=object)
        direction: Exact = random_rotation(random)[:, 2]
        offset: Exact = self.distance * direction
        return offset


def circle_point(random: Random) -> tuple[Fraction, Fraction]:
    """Return cosine and sine, both rational and neither zero, of a random angle."""
    slope = Fraction(random.randint(1, 20), random.randint(21, 40)) * random.choice((-1, 1))
    square = slope * slope
    return (1 - square) / (1 + square), 2 * slope / (1 + square)


def sample(kind: Kind, random: Random) -> RationalConstraint:
    """Return a random rational instance of a kind of constraint."""
    cosine, sine = circle_point(random)
    return RationalConstraint(
        kind,
        random_rotation(random),
        random_rotation(random),
        random_vector(random),
        random_vector(random),
        Fraction(random.randint(1, 20), random.randint(1, 9)),
        cosine,
        sine,
    )
