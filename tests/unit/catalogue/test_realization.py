"""Chains of joints, held against the gradients of the distances and angles in exact arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import pytest

from gspcli.catalogue.coincidence import coincident_types, parse_sharing
from gspcli.catalogue.kinds import AHH, ALH, ALL, DLL, DPH, DPL, KINDS, Kind
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.realization import (
    SAMPLE,
    Chain,
    JointAxis,
    JointKind,
    Line,
    Realization,
    Screw,
    Vector,
    alternative,
    chain,
    dependencies,
    mechanism,
    mechanism_of_type,
    outside,
    rank,
    realization,
    sample_axes,
    vector,
)
from gspcli.catalogue.types import GspType, all_types

#: Configurations with nothing special between the primitives.
CONFIGURATIONS: list[tuple[Line, Line]] = [
    SAMPLE,
    ((vector(1, 7, -4), vector(2, -3, 5)), (vector(6, -2, 3), vector(-1, 4, 3))),
    ((vector(-8, 0, 5), vector(1, 1, 9)), (vector(2, 3, 0), vector(7, -2, 1))),
]
BOTH = (DLL, ALL)
SINGLE = [make(kind) for kind in KINDS for make in (realization, alternative, outside)]
ALL_CHAINS = [*SINGLE, realization(*BOTH), alternative(*BOTH), outside(*BOTH)]


def name(value: object) -> str:
    if isinstance(value, Realization):
        return f"{'+'.join(map(str, value.kinds))}:{value.chain.name}"
    return str(value)


@dataclass(frozen=True)
class Dual:
    """A number with its derivative: enough to differentiate rational functions exactly."""

    value: Fraction
    slope: Fraction

    def __add__(self, other: Dual) -> Dual:
        return Dual(self.value + other.value, self.slope + other.slope)

    def __sub__(self, other: Dual) -> Dual:
        return Dual(self.value - other.value, self.slope - other.slope)

    def __mul__(self, other: Dual) -> Dual:
        return Dual(self.value * other.value, self.slope * other.value + self.value * other.slope)

    def __truediv__(self, other: Dual) -> Dual:
        value = self.value / other.value
        return Dual(value, (self.slope - value * other.slope) / other.value)


Triple = tuple[Dual, Dual, Dual]


def dual_cross(a: Triple, b: Triple) -> Triple:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dual_dot(a: Triple, b: Triple) -> Dual:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def at_rest(a: Vector) -> Triple:
    x, y, z = (Dual(c, Fraction(0)) for c in a)
    return (x, y, z)


def moving(a: Vector, velocity: Vector) -> Triple:
    x, y, z = (Dual(c, s) for c, s in zip(a, velocity, strict=True))
    return (x, y, z)


def square_of_measure(kind: Kind, a: Triple, u: Triple, b: Triple, v: Triple) -> Dual:
    """Return d^2, or cos^2 or sin^2 of the angle, from the definitions of Section 4."""
    apart = (b[0] - a[0], b[1] - a[1], b[2] - a[2])

    def to_line(direction: Triple) -> Dual:
        product = dual_cross(apart, direction)
        return dual_dot(product, product) / dual_dot(direction, direction)

    def along(direction: Triple) -> Dual:
        product = dual_dot(apart, direction)
        return product * product / dual_dot(direction, direction)

    if not kind.is_distance:
        product = dual_dot(u, v)
        return product * product / (dual_dot(u, u) * dual_dot(v, v))
    return {
        "PP": lambda: dual_dot(apart, apart),
        "PL": lambda: to_line(v),
        "LP": lambda: to_line(u),
        "PH": lambda: along(v),
        "HP": lambda: along(u),
        "LL": lambda: along(dual_cross(u, v)),
    }[kind.short]()


def rate(kind: Kind, primitives: tuple[Line, Line], motion: Screw) -> Fraction:
    """Return how fast the measure changes while the platform moves."""
    (a, u), (b, v) = primitives
    spin, shift = (motion[0], motion[1], motion[2]), (motion[3], motion[4], motion[5])

    def velocity(at: Vector, offset: Vector) -> Vector:
        turn = (
            spin[1] * at[2] - spin[2] * at[1],
            spin[2] * at[0] - spin[0] * at[2],
            spin[0] * at[1] - spin[1] * at[0],
        )
        return (turn[0] + offset[0], turn[1] + offset[1], turn[2] + offset[2])

    still = vector(0, 0, 0)
    measure = square_of_measure(
        kind, moving(a, velocity(a, shift)), moving(u, velocity(u, still)), at_rest(b), at_rest(v)
    )
    return measure.slope


@pytest.mark.parametrize("primitives", CONFIGURATIONS)
@pytest.mark.parametrize("made", ALL_CHAINS, ids=name)
def test_a_held_chain_keeps_the_measure_and_allows_all_else(
    made: Realization, primitives: tuple[Line, Line]
) -> None:
    # Screws that keep every measure, and as many of them independent as there can be, span
    # exactly the kernel of the gradients.
    axes = sample_axes(made.kinds[0], primitives)
    held = made.chain.locked.screws(axes)
    assert rank(held) == 6 - len(made.kinds) == made.held_freedoms
    for kind in made.kinds:
        assert all(rate(kind, primitives, screw) == 0 for screw in held)


@pytest.mark.parametrize("primitives", CONFIGURATIONS)
@pytest.mark.parametrize("made", ALL_CHAINS, ids=name)
def test_a_chain_leaves_six_freedoms_and_its_motors_move_the_measures(
    made: Realization, primitives: tuple[Line, Line]
) -> None:
    axes = sample_axes(made.kinds[0], primitives)
    assert rank(made.chain.screws(axes)) == 6 == made.freedoms
    driven = [placed for placed in made.chain.joints if placed.driven]
    assert len(driven) == len(made.kinds)
    for placed in driven:
        (screw,) = Chain((placed,)).screws(axes)
        rates = [rate(kind, primitives, screw) != 0 for kind in made.kinds]
        turns = placed.joint is JointKind.REVOLUTE
        assert rates == [kind.is_distance != turns for kind in made.kinds]


def test_a_wrong_chain_is_found_out() -> None:
    # A planar joint at the line in place of the cylindrical one, and a slide across the leg.
    axes = sample_axes(DPL)
    assert any(rate(DPL, SAMPLE, screw) for screw in chain("S:platform E:base").screws(axes))
    across = chain("S:platform P*:across C:base")
    assert rank(across.screws(axes)) < 6


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_chains_of_mirrored_kinds_are_mirrored(kind: Kind) -> None:
    for make in (realization, alternative):
        mirrored = make(kind.mirrored).chain.name.split("-")
        assert sorted(mirrored) == sorted(make(kind).chain.name.split("-"))
        if kind.mirrored is not kind:
            assert mirrored[::-1] == make(kind).chain.name.split("-")


@pytest.mark.parametrize("made", ALL_CHAINS, ids=name)
def test_idle_freedoms(made: Realization) -> None:
    dependent = dependencies(made.chain.screws(sample_axes(made.kinds[0])))
    assert len(dependent) == made.idle_freedoms
    assert (made.idle_motion != "") is (made.idle_freedoms > 0)


def test_the_motions_that_are_idle() -> None:
    idle = {kind.name: realization(kind).idle_motion for kind in KINDS}
    turning = "leg turns about its own axis"
    assert {kind for kind, motion in idle.items() if motion} == {"DPP", "DPH", "DHP", "AHH"}
    assert idle["DPP"] == idle["DPH"] == idle["DHP"] == turning
    assert idle["AHH"] == "leg slides along its own axis"
    assert not any(alternative(kind).idle_freedoms for kind in KINDS)


def test_freedoms_of_the_joints() -> None:
    assert {joint.letter: joint.freedoms for joint in JointKind} == {
        "R": 1,
        "P": 1,
        "C": 2,
        "S": 3,
        "E": 3,
    }


def test_two_slides_beside_a_spherical_joint_are_not_enough_when_one_is_the_driver() -> None:
    # "A spherical and two prismatic joints" (Section 7) is two besides the driver of Figure 6.
    axes = sample_axes(DPH)
    short = chain("S:platform P*:leg P:across")
    assert (rank(short.screws(axes)), rank(short.locked.screws(axes))) == (5, 4)
    assert alternative(DPH).chain.name == "S-P*-P-P"


ORIGIN, X, Y, Z = vector(0, 0, 0), vector(1, 0, 0), vector(0, 1, 0), vector(0, 0, 1)
ASIDE = vector(3, 0, 0)


@pytest.mark.parametrize(
    ("kind", "platform", "base", "leg"),
    [
        (DLL, (ORIGIN, Z), (ASIDE, Z), (ORIGIN, X)),
        (ALL, (ORIGIN, Z), (ASIDE, Z), (ORIGIN, X)),
        (ALH, (ORIGIN, Z), (ASIDE, Z), (ORIGIN, X)),
        (AHH, (ORIGIN, Z), (ASIDE, Z), (ORIGIN, X)),
        (DPL, (ORIGIN, Z), (ORIGIN, Z), (ORIGIN, X)),
    ],
    ids=str,
)
def test_chains_jam_where_the_leg_has_no_direction_of_its_own(
    kind: Kind, platform: Line, base: Line, leg: Line
) -> None:
    # Parallel lines or normals, and a point on its line: the platform loses a freedom.
    axes = {JointAxis.PLATFORM: platform, JointAxis.BASE: base, JointAxis.LEG: leg}
    assert rank(realization(kind).chain.screws(axes)) < 6


@pytest.mark.parametrize("kinds", [*((kind,) for kind in KINDS), BOTH], ids=str)
def test_an_outside_driver_is_at_the_base_and_leaves_the_rest(kinds: tuple[Kind, ...]) -> None:
    inside, moved = realization(*kinds), outside(*kinds)
    joints = moved.chain.joints
    assert all(placed.driven for placed in joints[-len(kinds) :])
    assert moved.chain.locked == inside.chain.locked
    # The idle motion is that of the same link.
    assert moved.idle_motion == inside.idle_motion


def test_figure_8_is_the_outside_driver_of_a_point_and_a_line() -> None:
    assert (outside(DPL).chain.name, outside(DPL).figure) == ("S-C-P*", 8)


def test_the_page_lists_the_chains_that_there_are() -> None:
    page = (Path(__file__).resolve().parents[3] / "docs" / "types.md").read_text("utf-8")
    page = page.partition("## Realization by joints")[2]
    for kinds in [*((kind,) for kind in KINDS), BOTH]:
        made = realization(*kinds)
        name = kinds[0].name if len(kinds) == 1 else "DLL and ALL of the same lines"
        (row,) = (line for line in page.splitlines() if line.startswith(f"| {name} |"))
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        assert cells[1:4] == [made.chain.name, str(made.figure), str(made.chain.freedoms)]
        assert cells[4][:1] == ("1" if made.idle_freedoms else "")
        assert cells[5].split()[0] == alternative(*kinds).chain.name
        assert cells[6].split()[0] == outside(*kinds).chain.name


# Whole mechanisms: the sum of Kutzbach and Grübler, merged chains, shared joints.


FIGURE_2 = "L1-l3 L1^l3 L2-l4 L2^l4 L1^l4 L2-l3"


def test_every_type_has_six_freedoms_and_six_motors() -> None:
    for gsp_type in all_types():
        built = mechanism_of_type(gsp_type)
        assert built.moving_freedoms == 6 == built.driven
        assert len(built.chains) == 6
        assert built.shared == ()


def test_the_sum_for_six_legs() -> None:
    built = mechanism_of_type(parse_type("6PP"))
    assert (built.links, built.joints, built.joint_freedoms) == (14, 18, 42)
    assert built.sum_shown == "M = 6 (n - g - 1) + Σf = 6 (14 - 18 - 1) + 42 = 12; 12 - 6 idle = 6"


def test_figure_14_has_four_chains() -> None:
    built = mechanism(parse_sharing(FIGURE_2).bonds)
    names = [mounted.realization.chain.name for mounted in built.chains]
    assert sorted(names) == ["C-P-R*-C", "C-R*-P*-C", "C-R*-P*-C", "C-R-P*-C"]
    assert built.moving_freedoms == built.driven == 6
    together = [mounted for mounted in built.chains if len(mounted.constraints) == 2]
    bonds = parse_sharing(FIGURE_2).bonds
    for mounted in together:
        first, second = (bonds[index] for index in mounted.constraints)
        assert (first.platform, first.base) == (second.platform, second.base)
        assert [first.kind, second.kind] == list(mounted.realization.kinds)


@pytest.mark.parametrize("gsp_type", all_types()[::400], ids=str)
def test_every_pattern_has_six_freedoms_and_six_motors(gsp_type: GspType) -> None:
    for pattern in list(coincident_types(gsp_type))[::7]:
        built = mechanism(pattern.bonds)
        assert built.moving_freedoms == 6 == built.driven
        realized = sorted(index for mounted in built.chains for index in mounted.constraints)
        assert realized == list(range(6))


def test_shared_primitives() -> None:
    built = mechanism(parse_sharing("P1-p1 P1-p2 P2-p2 P2-h1 L1-l1 L2-l1").bonds)
    described = {(shared.body, shared.name): shared.joints for shared in built.shared}
    assert described == {
        ("platform", "P1"): "compound spherical joint: 2 S with one centre",
        ("platform", "P2"): "compound spherical joint: 2 S with one centre",
        ("base", "p1"): "compound spherical joint: 2 S with one centre",
        ("base", "l1"): "2 C on one shaft",
    }
    on_planes = mechanism(parse_sharing("P1-h1 P2-h1 P3-h1 P4-p1 P5-p2 P6-p3").bonds)
    (plane,) = on_planes.shared
    assert (plane.name, plane.joints, len(plane.chains)) == ("h1", "3 E on one plane", 3)
