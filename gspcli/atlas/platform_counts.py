"""Exact counts of poses, of one platform or of random platforms of a type."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias, overload

from gspcli import __version__
from gspcli.atlas.geometries import CLASSES, random_geometry
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import GspType
from gspcli.certification.counting import NotCountedError, count_geometry, count_results
from gspcli.certification.counting.count_results import PlatformCounts
from gspcli.defaults import LONG_COUNT, SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class GeometryCount:
    """The exact number of complex poses of random platforms of a class of geometry.

    Attributes
    ----------
    geometry, meaning
        The class, and what is special about it.
    count, distinct
        The number of poses with multiplicities, and of different ones; None if infinitely many.
    error
        A bound of the probability that the random prime misleads; 0 if the count is proved.
    of_type
        Whether it was too large to count, and is the generic count, proved for the type.
    """

    geometry: str
    meaning: str
    count: int | None
    distinct: int | None
    error: float
    of_type: bool = False

    @property
    def proof(self) -> str:
        """What proves the count, in words."""
        return "proved for the type" if self.of_type else count_results.proof_text(self.error)


@dataclass(frozen=True)
class TypeCounts:
    """The counts of classes of geometry of a type.

    Attributes
    ----------
    type
        The type.
    seed
        Of the random platforms and of the prime.
    counts
        One for each class.
    """

    type: GspType
    seed: int
    counts: tuple[GeometryCount, ...]

    def __repr__(self) -> str:
        counts = ", ".join(f"{one.geometry} {one.count}" for one in self.counts)
        return f"<TypeCounts of {self.type.id}: {counts}>"

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each class, as plain data."""
        return [
            {
                "geometry": one.geometry,
                "meaning": one.meaning,
                "count": one.count,
                "distinct": one.distinct,
                "proof": one.proof,
                "modulo_random_prime": one.error or False,
            }
            for one in self.counts
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each class (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.count-geometries/1``."""
        return {
            "schema": "gsp.count-geometries/1",
            "type": self.type.to_json(),
            "geometries": self.rows(),
            "seed": self.seed,
            "version": __version__,
        }


Classes: TypeAlias = Sequence[str] | str


@overload
def count(
    instance: Instance, *, geometries: Classes = ..., effort: float = ..., seed: int = ...
) -> PlatformCounts: ...


@overload
def count(
    instance: GspType | str | int,
    *,
    geometries: Classes = ...,
    effort: float = ...,
    seed: int = ...,
) -> TypeCounts: ...


def count(
    instance: Instance | GspType | str | int,
    *,
    geometries: Classes = ("generic",),
    effort: float = LONG_COUNT,
    seed: int = SEED,
) -> PlatformCounts | TypeCounts:
    """Count the complex poses of a platform, or of a type, exactly, without finding them.

    Parameters
    ----------
    instance
        The platform; or a type, such as ``"6PP"``, of which random platforms are counted.
    geometries
        With a type: the classes of geometry to count, as ``gsp count --geometry``, or ``"all"``.
    effort
        The most multiplications, in billions.
    seed
        Of the random prime, and of random platforms.

    Raises
    ------
    ArgumentError
        If there is no such class of geometry for the type.
    NotCountedError
        If a special geometry needs more multiplications.

    Examples
    --------
    >>> import gspcli
    >>> gspcli.count("6PP", geometries=["generic", "3-3"])
    <TypeCounts of DPP DPP DPP DPP DPP DPP: generic 40, 3-3 16>
    """
    if isinstance(instance, Instance):
        return count_results.count(instance, effort=effort, seed=seed)
    gsp_type = parse_type(str(instance)) if isinstance(instance, str | int) else instance
    names = possible_geometries(gsp_type) if geometries == "all" else geometries
    return count_type(gsp_type, [names] if isinstance(names, str) else names, effort, seed)


def possible_geometries(gsp_type: GspType) -> list[str]:
    """Return the classes of geometry that a type can have: those of joints are for legs only."""
    six_legs = set(gsp_type.kinds) == {DPP}
    return [name for name, one in CLASSES.items() if one.points is None or six_legs]


def count_type(
    gsp_type: GspType,
    names: Sequence[str],
    effort: float,
    seed: int,
    progress: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> TypeCounts:
    """Count random platforms of a type; `progress` is called for each class. As `count`."""
    possible = possible_geometries(gsp_type)
    for name in names:
        if name not in possible:
            message = f"found {name!r}, expected of {gsp_type.id}: {', '.join(possible)}"
            raise ArgumentError(message, "geometries")
    counts = [_counted(gsp_type, name, effort, seed) for name in progress(names)]
    return TypeCounts(gsp_type, seed, tuple(counts))


def _counted(gsp_type: GspType, name: str, effort: float, seed: int) -> GeometryCount:
    """Count a random platform of a class."""
    meaning = CLASSES[name].meaning
    platform = random_geometry(gsp_type, CLASSES[name], seed)
    try:
        found = count_geometry(platform, seed=seed, limit=effort)
    except NotCountedError:
        if name != "generic":
            raise
        # What almost every platform has is proved for the type, however large.
        number = generic_counts(gsp_type).two_sided
        return GeometryCount(name, meaning, number, number, 0.0, of_type=True)
    return GeometryCount(name, meaning, found.solutions, found.distinct, found.error)
