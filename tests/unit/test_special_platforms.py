"""The campaign of special platforms: its numbers modulo primes, its judge, its table."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import islice
from types import ModuleType

import pytest

from gspcli import loads
from gspcli.geometry.instance import Instance

SPEC = """\
gsp: 1
units: {{length: m, angle: {unit}}}
platform:
  L: {{line: {{point: [0, 0, 0], direction: [1, 2, 2]}}}}
  P: {{point: [sqrt(2), sqrt(8), sqrt(3)]}}
base:
  M: {{line: {{point: [0, 0, 0], direction: [1, 1, 0]}}}}
  H: {{plane: {{point: [0, 0, 0], normal: [1, 1, 1]}}}}
  Q: {{point: [0, 0, 0]}}
  S: {{point: [1, 0, 0]}}
constraints:
  - {{angle: [L, M], value: {angle}}}
  - {{angle: [L, H], value: {other}}}
  - {{distance: [P, H], value: 1, side: positive}}
  - {{distance: [P, Q], value: sqrt(7)}}
  - {{distance: [P, S], value: 2}}
  - {{distance: [P, M], value: 3}}
"""


def instance(angle: str, other: str = "30", unit: str = "deg") -> Instance:
    return loads(SPEC.format(angle=angle, other=other, unit=unit))


@pytest.fixture(scope="module")
def homomorphisms(load_tool: Callable) -> ModuleType:
    return load_tool("oracle.homomorphisms")


def test_square_roots_keep_their_products_and_are_those_of_cosines(
    homomorphisms: ModuleType,
) -> None:
    platform = instance("45")
    for field in islice(homomorphisms.fields(platform), 3):
        p = field.prime
        two, eight, _ = field.vector(platform.constraints[3].platform.position)
        assert two * two % p == 2
        assert two * eight % p == 4
        assert field.root(Fraction(3, 2)) * two % p == field.root(Fraction(3))
        cosine = field.cosine(platform.constraints[0])
        assert 2 * cosine % p == two
        # The sine of 30 degrees takes the place of a cosine.
        assert 2 * field.cosine(platform.constraints[1]) % p == 1


def test_angles_that_are_no_small_part_of_a_turn_keep_their_multiples(
    homomorphisms: ModuleType,
) -> None:
    platform = instance("60.00000000001", "60.00000000002")
    field = next(homomorphisms.fields(platform))
    p = field.prime
    c, s = (field.cosine(k) for k in platform.constraints[:2])
    # cos(60 + x) and sin(60 + 2x): 30 - 2x is 90 less that, and 60 + x twice is 120 + 2x.
    # With b = 60 + x: sin(60 + 2x) = sin(2b - 60), so 2 sin(60 + 2x) + sqrt(3) cos 2b = sin 2b.
    doubled = 2 * c * c - 1
    sine = 2 * s + field.root(Fraction(3)) * doubled
    assert (sine * sine + doubled * doubled) % p == 1


def test_inverse_cosines_and_radians(homomorphisms: ModuleType) -> None:
    platform = instance("acos(3/5)", "asin(5/13)", "rad")
    field = next(homomorphisms.fields(platform))
    p = field.prime
    assert 5 * field.cosine(platform.constraints[0]) % p == 3
    assert 13 * field.cosine(platform.constraints[1]) % p == 5
    with pytest.raises(homomorphisms.UnknownNumberError):
        next(homomorphisms.fields(instance("atan(2)", "1/2", unit="rad")))


RIGHT = {"finite": "yes", "count": "40", "distinct": "39", "real": "4"}


@pytest.mark.parametrize(
    ("verdict", "found", "multiple", "real", "certified", "judgement"),
    [
        ("complete", 39, 40, 4, 38, "right"),
        ("incomplete", 30, 30, 2, 30, "incomplete"),
        ("complete", 38, 40, 4, 38, "wrong complete"),
        ("infinite", 0, 0, 0, 0, "false infinite"),
        ("complete", 39, 39, 4, 39, "wrong multiplicity"),
        ("complete", 39, 40, 6, 38, "wrong real"),
        ("incomplete", 30, 30, 6, 30, "wrong real"),
        ("incomplete", 40, 40, 4, 40, "too many"),
    ],
)
def test_the_judge_sees_what_is_wrong(
    verdict: str,
    found: int,
    multiple: int,
    real: int,
    certified: int,
    judgement: str,
    load_tool: Callable,
) -> None:
    tool = load_tool("special.answers")
    answer = tool.Answer(verdict, found, multiple, real, certified, "none", 0.1)
    assert tool.judged(answer, RIGHT) == judgement


def test_what_is_infinite_must_be_said_to_be(load_tool: Callable) -> None:
    tool = load_tool("special.answers")
    exact = {"finite": "no", "count": "", "distinct": "", "real": ""}
    said = {v: tool.Answer(v, 0, 0, 0, 0, "none", 0.1) for v in ("infinite", "complete")}
    assert tool.judged(said["infinite"], exact) == "right"
    assert tool.judged(said["complete"], exact) == "wrong complete"


def test_answers_that_depend_on_the_seed_are_wrong(load_tool: Callable) -> None:
    tool = load_tool("special.answers")
    judgement = tool.Judgement()
    answers = [tool.Answer("incomplete", n, n, 2, n, "none", 0.1) for n in (30, 31)]
    judgement.add("group/a", answers, "", RIGHT, 5.0)
    judgement.add("group/b", answers[:1], "", RIGHT, 5.0)
    judgement.add("group/c", [], "an exception", RIGHT, 5.0)
    assert judgement.total == {"seeds": 1, "incomplete": 1, "failed": 1}
    assert judgement.wrong == 2
    assert "group" in judgement.text()
    assert "| group | 3 | 0 | 0 | 1 | 2 | 0.1 |" in judgement.markdown()


def test_the_table_is_of_the_platforms_as_they_are_made(load_tool: Callable) -> None:
    tool = load_tool("special.platforms")
    rows = tool.recorded()
    assert len(rows) >= 800
    for platform in tool.platforms(["hexagons", "double", "dependent"]):
        assert rows[platform.id]["sha256"] == platform.sha256
    for row in rows.values():
        assert row["first_by"].split()[1] != row["second_by"].split()[1]
        if row["finite"] == "yes":
            assert 0 <= int(row["real"] or 0) <= int(row["distinct"]) <= int(row["count"])
            if row["real"]:
                assert (int(row["real"]) - int(row["distinct"])) % 2 == 0
