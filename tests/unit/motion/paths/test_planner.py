"""Signs that regular paths keep."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_vector
from gspcli.motion.paths.planner import Classes, home_map
from gspcli.motion.paths.ways import PoseWays, ValueWays
from gspcli.pictures.live_numbers import live_home
from gspcli.solver import SolveResult, solve
from gspcli.spec.reading import example
from tests.unit.motion.paths.test_ways import ways_of

#: What the factors of some platforms are of.
FACTORS = {
    "platform-6-6": [],
    "sdss-primary": [((0, 1, 2), "one direction of the base")],
    "surfaces-sss": [((3, 4, 5), "angles")],
    "fixture-3-2-1": [((0, 1, 2), "one direction of the platform")],
    "figure-4": [((3, 4, 5), "angles"), ((0, 1, 2), "one point of the platform")],
}


@pytest.mark.parametrize("name", FACTORS)
def test_factors_are_found(name):
    instance = gspcli.example(name)
    classes = Classes(instance, PoseWays(instance, limits=False))
    found = {(one.constraints, one.space) for one in classes.factors}
    expected = set(FACTORS[name])
    if name == "sdss-primary":
        # Which of its planes are parallel the file says.
        assert [len(one.constraints) for one in classes.factors] == [3]
    else:
        assert expected <= found
    assert bool(found) == bool(expected)


@pytest.mark.parametrize(
    "name",
    ["sdss-primary", "surfaces-sss", "surfaces-scc", "fixture-3-2-1", "figure-2", "figure-4"],
)
def test_a_proved_way_keeps_all_signs(name):
    """The proof of ways does not use factors."""
    ways, modes = ways_of(name, limits=False)
    classes = Classes(ways.instance, ways)
    draw = np.random.default_rng(4)
    proved, seen = 0, set()
    for k in range(80):
        begin = modes[k % len(modes)]
        end = begin + draw.normal(size=6) * ways.sizes * 10.0 ** -draw.integers(0, 3)
        first, last = (classes.of(*ways.poses(one)) for one in (begin, end))
        seen.add(first.signs)
        if ways.prove(begin, end).sign:
            proved += 1
            assert first.differs(last) is None
            assert first.signs == last.signs
    assert proved > 10
    assert len(seen) == 4


#: Distances of a point from the axes of the other body, and angles of axes, from either body.
AXES = """
gsp: 1
type: {type}
units: {{length: unit, angle: deg}}
{own}:
  P1: {{point: [1, 2, 0]}}
  L1: {{line: {{point: [0, 0, 0], direction: [0, 0, 1]}}}}
  L2: {{line: {{point: [0, 0, 0], direction: [0, 1, 0]}}}}
  L3: {{line: {{point: [0, 0, 0], direction: [1, 0, 0]}}}}
{other}:
  L4: {{line: {{point: [3, -1, 5], direction: [0, 0, 1]}}}}
  L5: {{line: {{point: [3, 7, {height}], direction: [0, 1, 0]}}}}
  L6: {{line: {{point: [8, -1, 2], direction: [1, {skew}, 0]}}}}
constraints:
  - {{angle: [{a}], value: 60}}
  - {{angle: [{b}], value: 60}}
  - {{angle: [{c}], value: 60}}
  - {{distance: [{d}], value: 6}}
  - {{distance: [{e}], value: 4}}
  - {{distance: [{f}], value: 5}}
"""


def axes(tmp_path, *, swapped=False, height="2", skew="0"):
    """Return a platform of the type of example 6.8; of the base's point if swapped."""
    pairs = (("L1", "L4"), ("L2", "L5"), ("L3", "L6"), ("P1", "L4"), ("P1", "L5"), ("P1", "L6"))
    text = [", ".join(pair[::-1] if swapped else pair) for pair in pairs]
    file = tmp_path / "axes.yaml"
    bodies = ("base", "platform") if swapped else ("platform", "base")
    kind = "DLP" if swapped else "DPL"
    words = {
        "type": " ".join(3 * [kind] + 3 * ["ALL"]),
        "own": bodies[0],
        "other": bodies[1],
        "height": height,
        "skew": skew,
    }
    named = dict(zip("abcdef", text, strict=True))
    file.write_text(AXES.format(**words, **named), encoding="utf-8")
    return gspcli.load(file)


@pytest.mark.parametrize("swapped", [False, True])
def test_products_of_places_and_turns(tmp_path, swapped):
    """The determinants of three angles and of three forces are products of three and four."""
    instance = axes(tmp_path, swapped=swapped)
    ways = PoseWays(instance, limits=False)
    classes = Classes(instance, ways)
    angles = [k for k, one in enumerate(classes.factors) if "quaternion" in one.space]
    places = [k for k, one in enumerate(classes.factors) if one.space.startswith("place")]
    assert (len(angles), len(places), len(classes.factors)) == (3, 3, 8)
    draw = np.random.default_rng(1)
    seen = set()
    for _ in range(20):
        R, T = rotation_from_vector(draw.normal(size=3)), draw.normal(size=3) * 9
        signs = classes.of(R, T).signs[1:]
        moments, forces = (
            next(s for s, one in zip(signs, classes.factors, strict=True) if one.space == space)
            for space in ("angles", f"one point of the {'base' if swapped else 'platform'}")
        )
        product = np.prod(quaternion_from_rotation(R))
        turns = np.prod([signs[k] for k in angles])
        assert turns == -np.sign(product)
        seen.add((moments * turns, forces * np.prod([signs[k] for k in places])))
    assert len(seen) == 1


@pytest.mark.parametrize("changed", [{"height": "2.001"}, {"skew": "0.001"}])
def test_lines_that_do_not_meet_or_are_skew_have_no_such_products(tmp_path, changed):
    instance = axes(tmp_path, **changed)
    classes = Classes(instance, PoseWays(instance, limits=False))
    assert not any(one.space.startswith("place") for one in classes.factors)
    assert any("quaternion" in one.space for one in classes.factors) == ("height" in changed)


def test_each_mode_of_example_6_8_is_of_its_own_class():
    ways, modes = ways_of("example-6.8", limits=False)
    classes = Classes(ways.instance, ways)
    assert len({classes.of(*ways.poses(one)).signs for one in modes}) == len(modes) == 64
    draw = np.random.default_rng(4)
    proved = 0
    for k in range(60):
        begin = modes[k]
        end = begin + draw.normal(size=6) * ways.sizes * 10.0 ** -draw.integers(0, 3)
        if ways.prove(begin, end).sign:
            proved += 1
            first, last = (classes.of(*ways.poses(one)) for one in (begin, end))
            assert first.signs == last.signs
    assert proved > 10


def test_an_unknown_sign_differs_from_none():
    instance = gspcli.example("surfaces-sss")
    classes = Classes(instance, PoseWays(instance, limits=False))
    R, T = np.eye(3), np.zeros(3)
    at = classes.of(R, T)
    unknown = type(at)((0, 0))
    assert unknown.text == "??"
    assert at.differs(unknown) is None
    assert type(at)((1, -1)).differs(type(at)((1, 1))) == 1
    assert type(at)((1, -1)).differs(type(at)((-1, 1))) == 0


# The small map of poses from which proved ways lead home.


def solved(name: str) -> tuple[SolveResult, int]:
    result = solve(example(name))
    return result, 0 if result.home is None else result.home.number - 1


def test_every_edge_of_a_map_of_values_is_proved_and_leads_home() -> None:
    result, home = solved("workspace-study")
    found = home_map(result, home)
    assert found is not None
    n = len(found.T)
    assert (np.abs(found.T[0] - result.T[home].real) < 1e-9).all()
    ways = ValueWays(result.instance, np.ones(6))
    values, points = ways.values(found.R, found.T), ways.points(found.R, found.T)
    assert ways.kept(values).all()
    pairs = np.stack((values[1:], values[found.after[1:]]), axis=1)
    arrived = ways.follow(pairs, np.arange(n - 1), points[1:])
    assert arrived.there.all()
    assert ways.same(arrived.points[:, -1], points[found.after[1:]]).all()
    here = np.arange(n)
    for _ in range(n):
        here = found.after[here]
    assert not here.any()
    # Seven other modes have the sign of home.
    modes = ways.points(result.R[result.real].real, result.T[result.real].real)
    assert sum(bool(ways.same(points, one).any()) for one in modes) == 8


def test_every_edge_of_a_map_of_poses_is_proved() -> None:
    result, home = solved("nano-hexapod")
    found = home_map(result, home)
    assert found is not None
    ways = PoseWays(result.instance, limits=False)
    numbers = ways.parameters(found.R, found.T)
    for k, after in enumerate(found.after.tolist()):
        if k:
            assert ways.prove(numbers[k], ways.nearest(numbers[k], numbers[after])).sign


def test_of_a_mode_that_fills_its_ranges_there_is_no_map() -> None:
    assert home_map(*solved("rubin-camera")) is None


def test_poses_of_a_map_keep_the_cones() -> None:
    result, home = solved("workspace-study-cones")
    found = home_map(result, home)
    assert found is not None
    assert Machine.of(result.instance).keeps(found.R, found.T).all()


@pytest.mark.parametrize("name", ["three-prs", "modified-paradex", "surfaces-ppp"])
def test_pages_of_all_machines_have_what_they_need(name: str) -> None:
    result, _ = solved(name)
    found = live_home(result)
    assert len(found["poses"]) == len(found["after"])
    assert all(-1 <= k < len(found["poses"]) and k != i for i, k in enumerate(found["after"]))
    assert found["signed"] == (name != "surfaces-ppp")
    within = [pair for pair in found["within"] if pair is not None]
    assert all(low <= high for low, high in within)
