"""The three counts of a platform (type, geometry, exact) with their proofs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli import __version__
from gspcli.certification.counting.exact_counts import ExactCount
from gspcli.certification.counting.modular_platform import NotCountedError
from gspcli.certification.counting.platform_counts import count_exactly, count_geometry
from gspcli.defaults import LONG_COUNT, SEED
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class PlatformCounts:
    """The exact numbers of complex poses of a platform.

    Attributes
    ----------
    instance
        The platform, its numbers taken as written.
    seed
        Of the random prime.
    geometry, exact
        The counts for almost all values and for the values of the instance; None if not counted.
    refusal
        The reason why a count is missing, or empty.
    """

    instance: Instance
    seed: int
    geometry: ExactCount | None
    exact: ExactCount | None
    refusal: str = ""

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        if self.exact is None:
            return f"<PlatformCounts of {kinds}: type {self.type_count}, not counted exactly>"
        if not self.exact.finite:
            return f"<PlatformCounts of {kinds}: infinitely many poses>"
        counts = f"exact {self.exact.solutions}, {self.exact.distinct} of them distinct"
        return f"<PlatformCounts of {kinds}: type {self.type_count}, {counts}>"

    @property
    def type_count(self) -> int:
        """The generic count of the type for the sides asked for."""
        return self.instance.expected

    def to_frame(self) -> pd.DataFrame:
        """Return one row: the counts, and bounds of the probability of errors; imports pandas."""
        import pandas as pd

        document = self.to_json()
        keys = ("type_count", "geometry_count", "exact_count", "distinct", "finite", "at_least")
        return pd.DataFrame([{key: document[key] for key in keys}])

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.count/1``."""
        exact, geometry = self.exact, self.geometry
        return {
            "schema": "gsp.count/1",
            **self.instance.to_json(),
            "type_count": self.type_count,
            "geometry_count": geometry.solutions if geometry else None,
            "exact_count": exact.solutions if exact else None,
            "distinct": exact.distinct if exact else None,
            "finite": exact.finite if exact else None,
            "spurious": exact.spurious if exact else None,
            "spurious_distinct": exact.spurious_distinct if exact else None,
            "at_least": exact.proved_lower if exact else None,
            "proof": {
                "type_count": {"modulo_random_prime": False},
                "geometry_count": _proof(geometry.error if geometry else None),
                "exact_count": _proof(exact.error if exact else None),
                "distinct": _proof(exact.distinct_error if exact else None),
            },
            "sides": [
                {
                    "signs": list(side.signs),
                    "exact_count": side.solutions,
                    "distinct": side.distinct,
                }
                for side in (exact.sides if exact else ())
            ],
            "primes": list(exact.primes) if exact else [],
            "seed": self.seed,
            "version": __version__,
        }


def count(instance: Instance, *, effort: float = LONG_COUNT, seed: int = SEED) -> PlatformCounts:
    """Count the complex poses of a platform exactly, without finding them.

    Parameters
    ----------
    instance
        The platform.
    effort
        The most multiplications, in billions.
    seed
        Of the random prime.
    """
    geometry = exact = None
    refusal = ""
    try:
        geometry = count_geometry(instance, seed=seed, limit=effort)
        exact = count_exactly(instance, seed=seed, limit=effort)
    except NotCountedError as error:
        refusal = str(error)
    return PlatformCounts(instance, seed, geometry, exact, refusal)


def _proof(error: float | None) -> dict[str, Any] | None:
    return None if error is None else {"modulo_random_prime": error or False}


def proof_text(error: float) -> str:
    """Return in words how sure a count is; the error is rounded up to a power of ten."""
    if error == 0:
        return "proved"
    power = next(k for k in range(-17, 1) if error <= float(f"1e{k}"))
    return f"random prime, error below 1e{power}"
