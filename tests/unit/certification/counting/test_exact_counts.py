from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.names import parse_name
from gspcli.certification.counting import (
    NotCountedError,
    count_exactly,
    count_geometry,
    exact_count,
    geometry_count,
)
from gspcli.geometry.numbers import Number, parse_number
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_directory, data_json
from gspcli.spec import load

EXPECTED = data_json("examples", "expected.json")["examples"]


def example(name: str):
    return load(data_directory() / "examples" / f"{name}.yaml")


@pytest.mark.parametrize("name", EXPECTED)
def test_examples_have_their_groebner_counts(name):
    record = EXPECTED[name]
    count = count_exactly(example(name))
    assert count.finite == (record["dimension"] == 0)
    if count.finite:
        assert (count.solutions, count.distinct) == (record["complex"], record["distinct"])
        assert count.error < 1e-9
        assert count.proved_lower == count.solutions
    else:
        assert count.solutions is None
        assert 0 < count.error < 1e-9


@pytest.mark.parametrize("name", ["dietmaier", "example-6.8", "six-planes", "platform-5-5"])
def test_without_solutions_at_infinity_one_prime_proves_the_count(name):
    count = count_exactly(example(name))
    assert count.error == 0
    assert count.distinct_error == 0


def test_special_hexagons_have_fewer_poses_and_rounded_ones_do_not():
    special = example("planar-hexagons")
    assert (count_exactly(special).solutions, count_geometry(special).solutions) == (28, 28)
    row = special.constraints[0]
    x, *rest = row.base.position
    moved = replace(row.base, position=(Number.of(x.value + 1e-9), *rest))
    rounded = replace(special, constraints=(replace(row, base=moved), *special.constraints[1:]))
    assert count_exactly(rounded).solutions > 28


def test_a_double_pose_that_the_data_split_is_two():
    instance = example("singular-pose")
    assert count_exactly(instance).distinct == 39
    split = instance.with_values({0: parse_number("sqrt(3.25+1e-30)")})
    count = count_exactly(split)
    assert (count.solutions, count.distinct, count.distinct_error) == (40, 40, 0)


def test_sides_add_up():
    instance = example("parallel-lines")
    both = tuple(
        replace(row, side=type(row.side).BOTH) if row.kind.has_sides else row
        for row in instance.constraints
    )
    count = count_exactly(replace(instance, constraints=both))
    assert len(count.sides) == 8
    assert count.solutions == sum(side.solutions for side in count.sides)
    one = count_exactly(instance)
    assert one.solutions in {side.solutions for side in count.sides}


def test_what_cannot_be_counted_is_none_and_says_why():
    instance = example("dietmaier").with_values({0: parse_number("atan(2)")})
    assert exact_count(instance) is None
    with pytest.raises(NotCountedError, match="atan outside an angle"):
        count_exactly(instance)
    assert geometry_count(instance).solutions == 40


def test_a_hidden_division_by_zero_is_refused():
    # cos(72 degrees) - cos(144 degrees) is sqrt(5)/2.
    number = Number("-", (parse_number("2*cos(2*pi/5) - 2*cos(4*pi/5)"), parse_number("sqrt(5)")))
    instance = example("dietmaier").with_values({0: Number("/", (Number.of(1), number))})
    with pytest.raises(NotCountedError, match="divided by zero"):
        count_exactly(instance)


def test_the_limit_is_kept():
    assert exact_count(example("dietmaier"), limit=1e-6) is None
    with pytest.raises(NotCountedError, match="limit"):
        count_exactly(example("parallel-edges"), limit=0.01)


def test_seeds_change_the_prime_and_not_the_count():
    counts = [count_exactly(example("platform-6-4"), seed=seed) for seed in range(3)]
    assert {count.solutions for count in counts} == {32}
    assert len({count.primes for count in counts}) == 3
    assert counts[0] == count_exactly(example("platform-6-4"), seed=0)


def test_large_general_counts_are_proved_by_a_small_prime():
    instance = example("parallel-edges")
    general = count_geometry(load(data_directory() / "examples" / "point-on-line.yaml"))
    assert all(2**60 < prime < 2**61 for prime in general.primes)
    # 256 of 512: special, so that only a large prime counts.
    assert all(2**60 < prime < 2**61 for prime in count_exactly(instance).primes)


def test_a_small_prime_is_tried_first_for_many_solutions():
    gsp_type = parse_name("DPL DPL DPP DPP DPP DPH")
    instance, _ = random_instance(gsp_type, np.random.default_rng(1), one_sided=True)
    count = count_exactly(instance)
    [prime] = count.primes
    assert 2**29 < prime < 2**30
    assert (count.solutions, count.distinct) == (160, 160)
    assert count.error < 1e-15
