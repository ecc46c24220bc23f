"""The constraint equations: exact on motions made from the geometry, of the proved degrees."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
import sympy
from sympy import Matrix, Rational

from gspcli.catalogue.bounds import varieties
from gspcli.catalogue.constraints import constraint_facts as recorded_facts
from gspcli.catalogue.kinds import (
    AHH,
    ALL,
    DHP,
    DISTANCE_KINDS,
    DLL,
    DLP,
    DPH,
    DPL,
    DPP,
    KINDS,
    Kind,
)
from gspcli.resources import data_json
from gspcli.symbolic.exact_motions import RationalMotion, hilbert_function, random_motion
from tools.data.constraints import constraint_facts, unproved_degrees
from tools.equations.constraint_equations import (
    ANGLE,
    DISTANCE,
    LAZARD,
    MOTIONS,
    MOURRAIN,
    MOURRAIN_16,
    SYSTEMS,
    Vector,
    VectorFrame,
    base,
    equations,
    inner,
    lowest_degree,
    platform,
    setting,
    squared_distance,
    system,
    triple,
)
from tools.equations.exact_constraints import RationalConstraint, sample
from tools.equations.loci import loci, quadratic_part
from tools.equations.lower_degrees import constrained_motions, excludes_degree
from tools.equations.motions import evaluate, motion_blocks, motion_variables
from tools.equations.paper_degrees import difference_degree, paper_degree, written_equation


def exact(array: Any) -> Matrix:
    """Return an array of fractions as a SymPy matrix."""
    return Matrix(array.shape[0], 1 if array.ndim == 1 else 3, [*map(Rational, array.flat)])


def blocks_of(motion: RationalMotion) -> dict[str, Matrix]:
    return motion_blocks(exact(motion.rotation), exact(motion.translation))


def values_of(instance: RationalConstraint) -> dict[Any, Any]:
    """Return the value of the constraint, to substitute in its equations."""
    planes = (instance.kind.platform.value + instance.kind.base.value).count("H")
    cosine, sine = Rational(instance.cosine), Rational(instance.sine)
    # cos of the angle of the vectors is cos α, sin α, −cos α for none, one and two planes.
    of_alpha = ((cosine, sine), (sine, cosine), (-cosine, sine))[planes]
    return {
        DISTANCE: Rational(instance.distance),
        sympy.cos(ANGLE): of_alpha[0],
        sympy.sin(ANGLE): of_alpha[1],
    }


def sides(
    instance: RationalConstraint, motion: RationalMotion, left: Any, right: Any
) -> tuple[Any, Any]:
    vectors = {name: exact(vector) for name, vector in instance.vectors.items()}
    blocks = blocks_of(motion)
    values = values_of(instance)
    return tuple(evaluate(form, vectors, blocks).subs(values) for form in (left, right))


@pytest.mark.parametrize("kind", KINDS)
def test_all_equations_hold_exactly_where_the_geometry_says_so(kind: Kind) -> None:
    random = Random(kind.order)
    instance = sample(kind, random)
    for motion in (instance.motion(random, side=1) for _ in range(3)):
        for one_sided in (False, True):
            for way in equations(kind, one_sided=one_sided):
                left, right = sides(instance, motion, way.left, way.right)
                assert left == right, way.form
    elsewhere = random_motion(random)
    for way in equations(kind):
        left, right = sides(instance, elsewhere, way.left, way.right)
        assert left != right, way.form


@pytest.mark.parametrize("kind", [DPH, DHP])
def test_the_other_side_satisfies_the_two_sided_equation_only(kind: Kind) -> None:
    random = Random(1)
    instance = sample(kind, random)
    motion = instance.motion(random, side=-1)
    for way in equations(kind):
        left, right = sides(instance, motion, way.left, way.right)
        assert left == right
    (way,) = equations(kind, one_sided=True)
    left, right = sides(instance, motion, way.left, way.right)
    assert left == -right


@pytest.mark.parametrize("kind", KINDS)
def test_the_paper_s_equation_holds_too(kind: Kind) -> None:
    random = Random(20 + kind.order)
    instance = sample(kind, random)
    vectors = {name: exact(vector) for name, vector in instance.vectors.items()}
    motion = instance.motion(random, side=1)
    for one_sided in (False, True):
        written = written_equation(kind, one_sided=one_sided, components=vectors)
        assert sympy.expand(written.subs(motion_variables(motion)).subs(values_of(instance))) == 0


@pytest.mark.parametrize("kind", DISTANCE_KINDS)
def test_the_gram_quotient_is_the_least_distance(kind: Kind) -> None:
    random = Random(40 + kind.order)
    instance = sample(kind, random)
    vectors = {name: exact(vector) for name, vector in instance.vectors.items()}
    blocks = blocks_of(random_motion(random))
    numerator, denominator = (evaluate(form, vectors, blocks) for form in squared_distance(kind))
    where = setting(kind)

    def carried(vector: Vector) -> Matrix:
        column = vectors[str(vector.name)]
        return blocks["R"] * column if vector.frame is VectorFrame.PLATFORM else column

    offset = carried(where.platform.point) + blocks["T"] - carried(where.base.point)
    directions = [carried(direction) for direction in where.directions]
    # The shortest offset is the one perpendicular to all directions.
    for direction in Matrix.orthogonalize(*directions):
        offset -= direction * offset.dot(direction) / direction.dot(direction)
    assert offset.dot(offset) == numerator / denominator


def test_inner_and_triple_products_of_moving_vectors() -> None:
    random = Random(5)
    motion = random_motion(random)
    blocks = blocks_of(motion)
    vectors = {name: exact(random_motion(random).translation) for name in "abcd"}
    moved = {
        platform("a"): blocks["R"] * vectors["a"],
        platform("b"): blocks["R"] * vectors["b"],
        base("c"): vectors["c"],
        base("d"): vectors["d"],
        Vector(sympy.Symbol("T"), VectorFrame.TRANSLATION): blocks["T"],
    }
    for x, x_value in moved.items():
        for y, y_value in moved.items():
            assert evaluate(inner(x, y), vectors, blocks) == x_value.dot(y_value)
            for z, z_value in moved.items():
                if [x, y, z].count(Vector(sympy.Symbol("T"), VectorFrame.TRANSLATION)) > 1:
                    continue
                expected = Matrix.hstack(x_value, y_value, z_value).det()
                assert evaluate(triple(x, y, z), vectors, blocks) == expected


def test_paper_degrees_are_those_of_proposition_4_1() -> None:
    lazard = {kind.name: paper_degree(kind, LAZARD) for kind in KINDS}
    mourrain = {kind.name: paper_degree(kind, MOURRAIN) for kind in KINDS}
    printed = {"DPL": 2, "DPH": 2, "DLP": 4, "DHP": 4, "DLL": 4}
    printed |= dict.fromkeys(("ALL", "ALH", "AHL", "AHH"), 1)
    assert lazard == printed | {"DPP": 2}
    assert mourrain == printed | {"DPP": 1}
    # Section 4: two linear equations for DPH, two quadratic ones for DHP.
    assert paper_degree(DPH, LAZARD, one_sided=True) == 1
    assert paper_degree(DHP, LAZARD, one_sided=True) == 2


@pytest.mark.parametrize(
    ("kind", "coordinates", "two_sided", "one_sided"),
    [
        (DPP, "R,T,U,rho", 1, 1),
        (DPL, "R,T", 2, 2),
        (DLP, "R,U", 2, 2),
        (DPH, "R,T", 2, 1),
        (DHP, "R,U", 2, 1),
        (DLL, "R,TxR", 2, 2),
        (ALL, "R", 1, 1),
        (AHH, "R", 1, 1),
    ],
)
def test_lowest_degrees(kind: Kind, coordinates: str, two_sided: int, one_sided: int) -> None:
    found = lowest_degree(kind)
    assert (found.coordinates.name, found.degree) == (coordinates, two_sided)
    assert lowest_degree(kind, one_sided=True).degree == one_sided


@pytest.mark.parametrize("kind", KINDS)
def test_no_polynomial_of_lower_degree(kind: Kind) -> None:
    # Another random instance than the one that the tool took.
    assert unproved_degrees(kind, seed=1) == []


def test_a_line_distance_is_cubic_with_rho_and_quartic_without() -> None:
    motions = constrained_motions(DLL, 520)
    for coordinates, degree in ((LAZARD, 4), (MOURRAIN_16, 3)):
        variety = varieties()[coordinates.name]
        assert recorded_facts(DLL).degrees[coordinates.name].two_sided == degree
        below = hilbert_function(variety.hilbert_numerator, 6, degree - 1)
        assert excludes_degree(coordinates, motions, degree - 1, below)
    # The proof fails where there is a polynomial: at the degree itself.
    at = hilbert_function(varieties()["R,T,U,rho"].hilbert_numerator, 6, 3)
    assert not excludes_degree(MOURRAIN_16, motions, 3, at)


def test_only_point_distances_have_linear_differences() -> None:
    for kind in KINDS:
        for coordinates in SYSTEMS:
            row = recorded_facts(kind).degrees.get(coordinates.name)
            assert row is None or (row.difference is not None) == (
                kind is DPP and coordinates.name in ("R,T,U", "R,T,U,TxR")
            )
    assert difference_degree(DPP, LAZARD.degrees) == 1


def test_loci_are_those_of_proposition_6_4() -> None:
    letters = {kind.name: loci(kind)["generic"].surface for kind in DISTANCE_KINDS}
    assert letters == {
        "DPP": "S", "DPL": "C", "DLP": "C", "DPH": "P", "DHP": "P", "DLL": "P"
    }  # fmt: skip
    assert loci(DLL)["parallel"].surface == "C"
    assert loci(ALL) == {}


def test_cylinders_have_the_direction_of_the_line_as_axis() -> None:
    for kind in (DPL, DLP):
        form = quadratic_part(kind)
        s, t = sorted(form.free_symbols, key=str)
        form = form.subs({s: Rational(2, 3), t: Rational(-1, 5)})
        # The stereographic image of (2/3, −1/5) in the unit sphere.
        axis = Matrix([300, -90, 116])
        assert form == sympy.eye(3) - axis * axis.T / axis.dot(axis)


@pytest.mark.parametrize("kind", KINDS)
def test_the_record_is_what_is_derived(kind: Kind) -> None:
    record = next(r for r in data_json("constraints.json")["constraints"] if r["kind"] == kind.name)
    assert constraint_facts(kind) == record


def test_coordinates_are_named_in_the_record_as_here() -> None:
    assert all(system(name) in SYSTEMS for name in recorded_facts(DPP).degrees)
    assert MOTIONS.name in recorded_facts(DPP).degrees
