"""Exact counts of poses, of one platform or of random platforms of a type."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from random import Random
from typing import Any, TypeAlias, overload

from gspcli import __version__
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DPP, Primitive
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import GspType
from gspcli.certification.counting import NotCountedError, count_geometry
from gspcli.certification.counting.exact_counts import PlatformCounts, count_platform, proof_text
from gspcli.defaults import LONG_COUNT, SEED
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, Vector, vector
from gspcli.records import Tabular, dataclass

#: Coordinates are integers of at most this size.
_SIZE = 1000
_LEGS = 6
#: Half of the square root of three, exactly.
_ROOT = Number("/", (Number("sqrt", (Number.of(3),)), Number.of(2)))

Triple = tuple[int, int, int]
Points = tuple[list[Vector], list[Vector]]


@dataclass(frozen=True)
class GeometryClass:
    """A class of geometries."""

    #: Its name on the command line.
    name: str
    #: The special property, in a phrase.
    meaning: str
    #: The platform and the base points of six legs, drawn at random; None for classes of every
    #: type.
    points: Callable[[Random], Points] | None = None


def random_geometry(gsp_type: GspType, chosen: GeometryClass, seed: int) -> Instance:
    """Return a random platform of a type with a geometry of a class; its values are arbitrary.

    Raises
    ------
    GspError
        If the class has six legs and the type does not.
    """
    rng = Random(f"{seed} {chosen.name} {gsp_type.id}")
    if chosen.points is None:
        flat = {"planar": "platform base", "planar-platform": "platform", "planar-base": "base"}
        planar = flat.get(chosen.name, "").split()
        pairs = [
            (
                _primitive(kind.platform, rng, flat="platform" in planar),
                _primitive(kind.base, rng, flat="base" in planar),
            )
            for kind in gsp_type.kinds
        ]
    else:
        if set(gsp_type.kinds) != {DPP}:
            message = f"found the geometry {chosen.name} of {gsp_type.id}, expected 6PP"
            raise GspError(message)
        platform, base = chosen.points(rng)
        pairs = [(Point(a), Point(b)) for a, b in zip(platform, base, strict=True)]
    rows = (
        Constraint(kind=kind, platform=a, base=b, value=Number.of(1))
        for kind, (a, b) in zip(gsp_type.kinds, pairs, strict=True)
    )
    return Instance(tuple(rows), Units("unit", AngleUnit.DEGREE), name=chosen.name)


def _primitive(sort: Primitive, rng: Random, *, flat: bool) -> Geometry:
    position = _exact(_triple(rng, flat=flat))
    if sort is Primitive.POINT:
        return Point(position)
    shape = Line if sort is Primitive.LINE else Plane
    return shape(position, _exact(_triple(rng)))


def _triple(rng: Random, *, flat: bool = False) -> Triple:
    x, y, z = (rng.randint(-_SIZE, _SIZE) for _ in range(3))
    return (x, y, 0 if flat else z)


def _exact(triple: Triple) -> Vector:
    return vector(*triple)


def _shared(platform: str, base: str) -> Callable[[Random], Points]:
    """Return legs between joints: for each leg the letter of its joint on either body."""

    def points(rng: Random) -> Points:
        joints = [{letter: _exact(_triple(rng)) for letter in word} for word in (platform, base)]
        return [joints[0][x] for x in platform], [joints[1][x] for x in base]

    return points


def _mapped(rng: Random, matrix: Callable[[Random], list[list[int]]], *, flat: bool) -> Points:
    """Return random base points, and platform points that are their images."""
    rows = matrix(rng)
    base = [_triple(rng, flat=flat) for _ in range(_LEGS)]
    image = [
        tuple(sum(a * x for a, x in zip(row, point, strict=True)) for row in rows) for point in base
    ]
    return [vector(*point) for point in image], [_exact(point) for point in base]


def _scaling(factor: int) -> Callable[[Random], list[list[int]]]:
    return lambda _: [[factor * (i == j) for j in range(3)] for i in range(3)]


def _linear(rng: Random) -> list[list[int]]:
    rows = [[rng.randint(-9, 9) for _ in range(3)] for _ in range(3)]
    # Planar points stay planar.
    rows[2][:2] = [0, 0]
    return rows


def _affine(rng: Random) -> list[list[int]]:
    return [[rng.randint(-9, 9) for _ in range(3)] for _ in range(3)]


def _hexagon(pair: tuple[int, int]) -> list[Vector]:
    """Return a hexagon of threefold symmetry: a mirrored pair of points, turned by thirds."""
    x, y = pair
    zero, half = Number.of(0), Number.of("-0.5")
    points = []
    for cosine, sine in ((Number.of(1), zero), (half, _ROOT), (half, _times(_ROOT, -1))):
        for sign in (1, -1):
            first = _sum(_times(cosine, x), _times(sine, -sign * y))
            second = _sum(_times(sine, x), _times(cosine, sign * y))
            points.append((first, second, zero))
    return points


def _hexagons(rng: Random) -> Points:
    platform, base = (_hexagon((rng.randint(1, _SIZE), rng.randint(1, _SIZE))) for _ in range(2))
    # Points that are neighbours on the platform are not neighbours on the base.
    return [*platform[1:], platform[0]], base


def _regular_hexagons(rng: Random) -> Points:
    platform, base = (_hexagon((0, rng.randint(1, _SIZE))) for _ in range(2))
    return platform, base


def _times(number: Number, factor: int) -> Number:
    return Number("*", (number, Number.of(factor)))


def _sum(a: Number, b: Number) -> Number:
    return Number("+", (a, b))


def _mirror(rng: Random) -> Points:
    """Return plane points in three pairs that a reflection exchanges, on both bodies."""
    bodies = []
    for _ in range(2):
        half = [_triple(rng, flat=True) for _ in range(_LEGS // 2)]
        bodies.append([vector(x, sign * y, 0) for x, y, _ in half for sign in (1, -1)])
    return bodies[0], bodies[1]


_CLASSES = (
    GeometryClass("generic", "nothing special"),
    GeometryClass("planar-base", "points of the base in a plane"),
    GeometryClass("planar-platform", "points of the platform in a plane"),
    GeometryClass("planar", "points of either body in a plane"),
    GeometryClass("mirror", "planar, with a mirror symmetry of both at once", _mirror),
    GeometryClass(
        "hexagons", "planar, with threefold symmetry: three pairs of points on a circle", _hexagons
    ),
    GeometryClass(
        "regular-hexagons",
        "two regular hexagons, corresponding corners joined: architecturally singular",
        _regular_hexagons,
    ),
    GeometryClass("6-5", "two legs share a joint of the platform", _shared("aabcde", "abcdef")),
    GeometryClass("6-4", "two pairs of legs share joints", _shared("aabbcd", "abcdef")),
    GeometryClass("6-4-triple", "three legs share a joint", _shared("aaabcd", "abcdef")),
    GeometryClass("6-3", "three pairs of legs share joints", _shared("aabbcc", "abcdef")),
    GeometryClass("5-5", "one pair shares a joint on either body", _shared("aabcde", "abbcde")),
    GeometryClass("5-4", "one pair on the base, two on the platform", _shared("aabbcd", "abbcde")),
    GeometryClass("4-4", "two pairs on either body, in a chain", _shared("aabbcd", "abbccd")),
    GeometryClass(
        "4-3", "two pairs on the base, three on the platform", _shared("aabbcc", "abbccd")
    ),
    GeometryClass("3-3", "the octahedron: three pairs on either body", _shared("aabbcc", "abbcca")),
    GeometryClass(
        "congruent", "congruent bodies", lambda rng: _mapped(rng, _scaling(1), flat=False)
    ),
    GeometryClass("similar", "similar bodies", lambda rng: _mapped(rng, _scaling(2), flat=False)),
    GeometryClass(
        "affine", "affinely equivalent bodies", lambda rng: _mapped(rng, _affine, flat=False)
    ),
    GeometryClass(
        "planar-congruent",
        "congruent bodies, planar",
        lambda rng: _mapped(rng, _scaling(1), flat=True),
    ),
    GeometryClass(
        "planar-similar", "similar bodies, planar", lambda rng: _mapped(rng, _scaling(2), flat=True)
    ),
    GeometryClass(
        "planar-affine",
        "affinely equivalent bodies, planar",
        lambda rng: _mapped(rng, _linear, flat=True),
    ),
)
#: All classes by name; those without points are classes of every type.
CLASSES: dict[str, GeometryClass] = {chosen.name: chosen for chosen in _CLASSES}


@dataclass(frozen=True)
class GeometryCount:
    """The exact number of complex poses of random platforms of a class of geometry."""

    #: The class, and what is special about it.
    geometry: str
    meaning: str
    #: The number of poses with multiplicities, and of different ones; None if infinitely many.
    count: int | None
    distinct: int | None
    #: A bound of the probability that the random prime misleads; 0 if the count is proved.
    error: float
    #: Whether it was too large to count, and is the generic count, proved for the type.
    of_type: bool = False

    @property
    def proof(self) -> str:
        """What proves the count, in words."""
        return "proved for the type" if self.of_type else proof_text(self.error)


@dataclass(frozen=True)
class TypeCounts(Tabular):
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
        return count_platform(instance, effort=effort, seed=seed)
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
