"""The recorded rigid-motion varieties: dimension and degree in each set of coordinates."""

from __future__ import annotations

from functools import cache

from gspcli.records import dataclass
from gspcli.resources import data_json


@dataclass(frozen=True)
class Variety:
    """The rigid motions as a variety in one set of coordinates (Section 3).

    Attributes
    ----------
    coordinates
        The blocks of coordinates, such as ``R,T,U``: R, T, U = RᵀT, rho = T·T and TxR, the
        matrix with columns T × R_k.
    ambient_dimension
        Number of coordinates.
    equations
        Number of the equations that generate the ideal.
    dimension
        6; 3 for the rotations alone.
    degree
        Degree of the projective closure.
    hilbert_numerator
        Coefficients of h in the Hilbert series h(t) / (1 - t)^(dimension + 1) of the projective
        closure; they add up to the degree.
    """

    coordinates: str
    ambient_dimension: int
    equations: int
    dimension: int
    degree: int
    hilbert_numerator: tuple[int, ...]

    @property
    def label(self) -> str:
        """The coordinates as people write them, such as ``(R, T, U, ρ)``."""
        return coordinates_label(self.coordinates)


#: Lazard's coordinates and Mourrain's, with 16 and with 25 entries (Section 3).
LAZARD = "R,T,U"
MOURRAIN_16 = "R,T,U,rho"
MOURRAIN = "R,T,U,rho,TxR"
#: The rotations alone.
ROTATIONS = "R"


def coordinates_label(coordinates: str) -> str:
    """Return coordinates as people write them.

    >>> coordinates_label("R,T,U,rho,TxR")
    '(R, T, U, ρ, T×R)'
    """
    return f"({coordinates.replace('rho', 'ρ').replace('x', '×').replace(',', ', ')})"


@cache
def varieties() -> dict[str, Variety]:
    """Return the varieties by their coordinates, the smallest first."""
    return {
        record["coordinates"]: Variety(
            **{**record, "hilbert_numerator": tuple(record["hilbert_numerator"])}
        )
        for record in data_json("varieties.json")["varieties"]
    }
