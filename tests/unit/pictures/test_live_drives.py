"""What a live page needs of a machine whose motors move its joints."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import gspcli
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose, moved
from gspcli.geometry.drive_numbers import driven_points
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, as_array
from gspcli.pictures.live_numbers import LiveMotors, _circle, anywhere, apart, counted, live_numbers
from gspcli.resources import instance_files
from gspcli.solver.starts.solved_starts import SolvedStarts

MACHINES = ("delta", "hexaglide", "t-top-head", "modified-paradex", "reachy-mini-head")


def machine(name: str) -> Instance:
    return gspcli.load(instance_files()[name])


@cache
def found_of(name: str) -> dict:
    return live_numbers(gspcli.solve(machine(name)))


@pytest.mark.parametrize("name", MACHINES)
def test_joints_anywhere_are_in_the_plane_or_on_the_line_of_their_motor(name: str) -> None:
    instance = machine(name)
    family, drives = anywhere(instance), Drives.of(instance)
    stated = Arrangement.of(instance)
    moved = Arrangement.of(family)
    assert not any(row.base.drive for row in family.constraints)
    for k in np.flatnonzero(drives.driven):
        off = moved.x[k] - drives.middle[k]
        axes = np.stack((drives.across[k], drives.beside[k]))
        left = off - axes.T @ np.linalg.lstsq(axes.T, off, rcond=None)[0]
        assert np.abs(left).max() < 1e-12 * stated.length
        # In general position: not on the circle, not where it is stated.
        radius = np.linalg.norm(axes @ off) / (axes**2).sum(axis=1).max()
        assert abs(radius - 1) > 1e-6
        assert np.linalg.norm(moved.x[k] - stated.x[k]) > 1e-3 * stated.length


def test_joints_of_one_motor_are_moved_alike() -> None:
    instance = machine("delta")
    family, drives = anywhere(instance), Drives.of(instance)
    for k in range(drives.count):
        one, two = drives.users(k)
        first, second = (as_array(family.constraints[i].base.position) for i in (one, two))
        before, after = (as_array(instance.constraints[i].base.position) for i in (one, two))
        np.testing.assert_allclose(second - first, after - before, atol=1e-9)


def test_motors_that_are_held_leave_their_joints() -> None:
    instance = machine("t-top-head")
    names = Drives.of(instance).names
    family = anywhere(instance, frozenset(names[1:]))
    same = [
        a.base.position == b.base.position
        for a, b in zip(family.constraints, instance.constraints, strict=True)
    ]
    assert same == [False, *[True] * 5]


@pytest.mark.parametrize(
    ("name", "still", "one", "most"),
    [("t-top-head", 36, 40, 40), ("delta", 28, 36, 40), ("hexaglide", 36, 36, 36)],
)
def test_counts_are_of_the_motors_that_have_moved(
    name: str, still: int, one: int, most: int
) -> None:
    counts = found_of(name)["counts"]
    assert (counts[0], counts[1], counts[-1]) == (still, one, most)
    assert counts[0] == gspcli.solve(machine(name)).geometry_count
    # More motors, no fewer poses.
    for mask, count in enumerate(counts):
        for k in range(len(counts).bit_length() - 1):
            assert counts[mask | 1 << k] >= count


def test_a_count_that_is_not_known_is_that_of_the_family(monkeypatch) -> None:
    monkeypatch.setattr(SolvedStarts, "count", lambda *_: None)

    class Family:
        found = 40

    assert counted(machine("delta"), Family()) == [None] * 8


def test_sliders_are_motors() -> None:
    found = found_of("reachy-mini-head")
    assert found["names"] == [f"crank.B{k}" for k in range(1, 7)]
    assert found["kinds"] == ["crank"] * 6
    assert found["values"] == [0.0] * 6
    assert found["units"] == ["deg"] * 6
    np.testing.assert_allclose(found["ranges"][0], [-83.9, 44.1])
    assert found["stated"] == {"poses": 40, "real": 16}
    shared = found_of("delta")
    assert (len(shared["values"]), shared["index"]) == (3, [0, 0, 1, 1, 2, 2])
    rails = found_of("hexaglide")
    assert rails["ranges"] == [[-2.0, 2.0]] * 6
    assert "random places" in rails["reservation"]


def test_machines_without_motors_on_joints_have_none_of_it() -> None:
    assert LiveMotors.of(machine("nano-hexapod")) is None
    assert not {"names", "counts", "index", "stated"} & set(found_of("nano-hexapod"))


@pytest.mark.parametrize("name", ["delta", "hexaglide"])
def test_circles_are_those_of_the_drives_with_more_digits(name: str) -> None:
    instance = machine(name)
    drives = Drives.of(instance)
    row = instance.constraints[2]
    (one,) = driven_points(row)
    found = _circle(one, 2.0)
    middle, across, beside = (part[:, 0] for part in found)
    scale = np.array([2.0, 2.0, 2.0 if isinstance(one.drive, Crank) else 1.0])
    for mine, theirs, unit in zip(
        (middle, across, beside),
        (drives.middle[2], drives.across[2], drives.beside[2]),
        scale,
        strict=True,
    ):
        np.testing.assert_allclose(mine * unit, theirs, atol=1e-13 * np.abs(theirs).max() + 1e-15)
    assert (np.abs(found[..., 1]) <= 2.0**-52 * np.abs(found[..., 0])).all()


def test_each_rod_gets_a_motor_of_its_own() -> None:
    alone = apart(machine("delta"))
    drives = Drives.of(alone)
    assert drives.count == 6
    assert np.isinf(drives.low).all()


@pytest.mark.parametrize(("name", "moving"), [("three-rps", 3), ("three-prs", 3), ("tricept", 4)])
def test_tripods_have_live_pages(name: str, moving: int) -> None:
    """Their planes at distance zero stay so, and one side of each is counted."""
    found = live_numbers(gspcli.solve(machine(name)))
    assert len(found["values"]) == 6
    assert sum(low < high for low, high in found["ranges"]) == moving
    assert found["proof"]["by"] == "geometry count"


def test_poses_of_a_delta_that_pages_do_not_prove_are_far_away_and_not_real() -> None:
    """With arms nearly alike a page proves 28 of 40 poses, all real ones among them."""
    delta = machine("delta")
    names = ["crank.B1", "crank.B3", "crank.B5"]
    result = gspcli.solve(moved(delta, choose(delta, names), np.array([1.0, 2.0, 3.0])))
    far = np.linalg.norm(result.T, axis=1) > 1000 * result.arrangement.length
    assert (result.verdict, len(far), far.sum()) == ("complete", 40, 12)
    assert not (far & result.real).any()


def test_readings_with_offsets_begin_where_the_file_has_the_joints() -> None:
    instance = machine("modified-paradex")
    rows = list(instance.constraints)
    slide = replace(rows[0].base.slide, offset=Number.of("0.25"))
    rows[0] = replace(rows[0], base=replace(rows[0].base, slide=slide))
    found = live_numbers(gspcli.solve(replace(instance, constraints=tuple(rows))))
    assert found["values"] == [-0.25, 0, 0, 0, 0, 0]
