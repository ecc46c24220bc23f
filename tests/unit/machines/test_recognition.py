"""Chains of joints as constraints: what is found, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import machine_models as models
import numpy as np
import pytest

import gspcli
from gspcli.errors import GspError
from gspcli.machines.api import ImportedMachine, import_machine
from gspcli.machines.graph import NoPlatform


@pytest.fixture
def imported(tmp_path: Path):
    def read(text: str, **options: object) -> ImportedMachine:
        path = tmp_path / "robot.xml"
        path.write_text(text, encoding="utf-8")
        return import_machine(path, **options)

    return read


def kinds(found: ImportedMachine) -> list[str]:
    return sorted(row.kind.name for row in found.instance.constraints)


def test_three_hinged_legs_are_distances_and_points_in_planes(imported) -> None:
    found = imported(models.rps())
    assert kinds(found) == ["DPH"] * 3 + ["DPP"] * 3
    assert found.base == "world"
    assert found.platform == "platform"
    for row in found.instance.constraints:
        low, high = (limit.value for limit in row.limits)
        if row.kind.name == "DPP":
            assert row.value.value == pytest.approx(np.hypot(0.4, 1))
            assert (low, high) == pytest.approx((row.value.value - 0.3, row.value.value + 0.3))
        else:
            assert (row.value.value, low, high) == (0, 0, 0)
    result = gspcli.solve(found.instance)
    assert result.verdict == "complete"
    assert result.counts.real == 8
    assert np.allclose(result.home.T, [0, 0, 1], atol=1e-9)


@pytest.mark.parametrize("leg", ["UPS", "UPRU"])
def test_a_leg_that_spins_is_one_distance(imported, leg: str) -> None:
    found = imported(models.legs([leg] * 6))
    assert kinds(found) == ["DPP"] * 6
    rng = np.random.default_rng(3)
    for row in found.instance.constraints:
        b, p = np.append(rng.normal(size=2), 0), np.append(rng.normal(size=2) * 0.6, 1)
        assert np.allclose(row.base.point, b, atol=1e-11)
        assert np.allclose(row.platform.point, p - [0, 0, 1], atol=1e-11)
        assert row.value.value == pytest.approx(np.linalg.norm(p - b), abs=1e-11)


def test_legs_that_cannot_spin_are_refused_with_their_count(imported) -> None:
    with pytest.raises(NoPlatform, match="which hold 12 constraints, expected six") as error:
        imported(models.legs(["UPU"] * 6))
    assert "6 R-R-P*-R-R" in str(error.value)
    assert "a hinge along each leg" in str(error.value)
    assert len(str(error.value).splitlines()) <= 3


def test_two_chains_are_refused_with_what_there_is(imported) -> None:
    with pytest.raises(NoPlatform, match="bodies on which three chains or more end: none") as error:
        imported(models.rps(2))
    assert "6 bodies" in str(error.value)
    assert "1 loop, 2 drives, mobility" in str(error.value)


@pytest.mark.parametrize(("offset", "meet", "read"), [(1e-5, 1e-4, True), (1e-2, 1e-4, False)])
def test_axes_that_nearly_meet(imported, offset: float, meet: float, read: bool) -> None:
    text = models.legs(["UPS"] * 6, offset=offset)
    if read:
        found = imported(text, meet=meet)
        assert kinds(found) == ["DPP"] * 6
        assert any("taken to meet" in note for note in found.notes)
        with pytest.raises(NoPlatform):
            imported(text, meet=0.0)
    else:
        with pytest.raises(NoPlatform, match=r"pass each other at 0\.01 m: --meet"):
            imported(text, meet=meet)
        assert kinds(imported(text, meet=2 * offset)) == ["DPP"] * 6


def test_driven_arms_are_cranks(imported) -> None:
    found = imported(models.rotary())
    assert kinds(found) == ["DPP"] * 6
    for i, row in enumerate(found.instance.constraints):
        assert row.limits is None
        assert row.base.crank is not None
        centre = np.array([number.value for number in row.base.crank.centre])
        assert np.linalg.norm(row.base.point - centre) <= 0.3 + 1e-10
        assert "which turns by -57.2958 to 57.2958 deg" in found.chains[i]
        low, high = (x.value for x in row.base.crank.limits)
        assert (low, high) == pytest.approx((-np.degrees(1), np.degrees(1)))
    assert gspcli.solve(found.instance).verdict == "complete"


def test_an_open_file_states_no_home(imported) -> None:
    closed, shut, wide = (imported(models.rps(gap=gap)) for gap in (0.0, 1e-5, 0.01))
    assert closed.instance.home is not None
    assert shut.instance.home is not None
    assert wide.instance.home is None
    for found in (shut, wide):
        assert any("misses the values by" in note for note in found.notes)
    for one, other in zip(closed.instance.constraints, wide.instance.constraints, strict=True):
        assert one.kind == other.kind


def test_bodies_can_be_chosen(imported) -> None:
    found = imported(models.rps(), base="platform")
    assert (found.base, found.platform) == ("platform", "world")
    assert kinds(found) == ["DHP"] * 3 + ["DPP"] * 3
    with pytest.raises(NoPlatform, match="no body 'plattform': did you mean 'platform'"):
        imported(models.rps(), platform="plattform")
    with pytest.raises(NoPlatform, match="no three chains that end on 'rod1'"):
        imported(models.rps(), platform="rod1")
    with pytest.raises(NoPlatform, match="rigid together"):
        imported(models.rps(), base="world", platform="world")


@pytest.mark.parametrize("options", [{"meet": -1}, {"meet": 1}, {"digits": 2}, {"digits": 18}])
def test_wrong_arguments(imported, options: dict[str, float]) -> None:
    with pytest.raises(GspError, match="found"):
        imported(models.rps(), **options)


@pytest.mark.parametrize("digits", [6, 12, 17])
def test_digits_of_numbers(imported, digits: int) -> None:
    found = imported(models.legs(["UPS"] * 6), digits=digits)
    exact = imported(models.legs(["UPS"] * 6), digits=17)
    off = [
        abs(one.value.value - other.value.value)
        for one, other in zip(found.instance.constraints, exact.instance.constraints, strict=True)
    ]
    assert max(off) <= 10.0 ** (1 - digits)
    assert digits == 17 or max(off) > 10.0 ** (-2 - digits)


def test_masses_and_gravity_come_along(imported) -> None:
    dynamics = imported(models.rps()).instance.dynamics
    assert dynamics is not None
    assert dynamics.platform.mass.value == pytest.approx(1000 * 4 / 3 * np.pi * 0.1**3)
    assert [x.value for x in dynamics.gravity] == [0, 0, -9.81]


def test_what_is_printed_reads_back(imported) -> None:
    for text in (models.rps(), models.rotary(), models.legs(["UPS"] * 6)):
        found = imported(text)
        assert gspcli.loads(found.text) == found.instance
        assert "ImportedMachine from MJCF" in repr(found)
        assert str(found) == found.text


def guided(tilt: float) -> str:
    """Return three legs, and three pairs of parallel hinges that keep points in planes.

    Parameters
    ----------
    tilt
        By how much the second hinge of each pair is out of parallel, in radians.
    """
    text = models.legs(["UPS"] * 3)
    bodies = closures = ""
    for i in range(3):
        t = 2 * np.pi * i / 3 + 0.3
        along, across = np.array([np.cos(t), np.sin(t), 0]), np.array([-np.sin(t), np.cos(t), 0])
        axis = across + tilt * np.array([0.6, 0.3, 0.7])
        bodies += (
            f'<body name="g{i}" pos="{models.row(1.5 * along)}"><joint type="hinge" '
            f'axis="{models.row(across)}"/><geom size=".02"/><body name="h{i}" '
            f'pos="{models.row(0.2 * along + [0, 0, 0.6])}"><joint type="hinge" '
            f'axis="{models.row(axis)}"/><geom size=".02"/></body></body>'
        )
        anchor = models.row(0.5 * along)
        closures += f'<connect body1="platform" body2="h{i}" anchor="{anchor}"/>'
    text = text.replace('<body name="platform"', bodies + '<body name="platform"')
    return text.replace("</equality>", closures + "</equality>")


@pytest.mark.parametrize("digits", range(1, 4))
def test_hinges_that_are_not_parallel_hold_no_plane(imported, digits: int) -> None:
    with pytest.raises(NoPlatform, match="expected six distances and angles"):
        imported(guided(10.0**-digits))


@pytest.mark.parametrize("digits", range(4, 15))
def test_hinges_that_are_nearly_parallel_are_said_to_be(imported, digits: int) -> None:
    found = imported(guided(10.0**-digits))
    assert kinds(found) == ["DPH"] * 3 + ["DPP"] * 3
    assert any("hold within" in note for note in found.notes) == (digits <= 6)
    if digits <= 6:
        with pytest.raises(NoPlatform):
            imported(guided(10.0 ** (1 - digits)), meet=0)


def test_driven_carriages_are_slides(imported) -> None:
    text = models.rotary().replace('type="hinge"', 'type="slide"').replace('"-1 1"', '"-.2 .4"')
    found = imported(text)
    assert kinds(found) == ["DPP"] * 6
    given = re.findall(r'type="slide" axis="([^"]*)"', text)
    for i, (row, axis) in enumerate(zip(found.instance.constraints, given, strict=True)):
        slide = row.base.slide
        along = np.array([float(x) for x in axis.split()])
        assert abs(slide.unit @ along) == pytest.approx(np.linalg.norm(along))
        assert [x.value for x in slide.limits] == pytest.approx([-0.2, 0.4])
        assert "base point on a rail, which slides by -0.2 to 0.4 m" in found.chains[i]
