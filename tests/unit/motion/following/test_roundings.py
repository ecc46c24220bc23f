"""Bounds of the kernel and of the controller: their own sources, counted and sampled."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[4]


def lines_of(folder: Path, name: str) -> list[str]:
    """Return what a program prints that is compiled with sources of the kernel."""
    for path in (ROOT / "native").iterdir():
        shutil.copy(path, folder)
    for path in (ROOT / "tests/support/counted").iterdir():
        if name in ("chord", "isolation", "far") or path.stem != "lanes":
            shutil.copy(path, folder)
    options = [
        "-std=c++20",
        "-O1",
        "-w",
        "-ffp-contract=off",
        f"-I{folder}",
        f"-I{ROOT / 'native'}",
    ]
    program = folder / name
    subprocess.run(["g++", *options, folder / f"{name}.cpp", "-o", program], check=True)
    return subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines()


@pytest.fixture(scope="module")
def counted(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return what the headers of the kernel count, with numbers that count for lanes."""
    return lines_of(tmp_path_factory.mktemp("counted"), "chord")


def test_no_term_goes_through_more_roundings_than_its_constant_allows(counted: list[str]) -> None:
    """Plain equations, products, and lines: values, parts times Y, and gradients times Y."""
    plain, others = (float(x) for x in counted[3].split()[1:])
    assert (plain, others) == (64, 128)
    for line, most in zip(counted[:3], (plain, others, others), strict=True):
        value, parts, gradient = map(int, line.split()[1:])
        # A gradient of degree four has four times the constant.
        assert 15 < value < parts < most
        assert 15 < gradient < most


def test_values_of_angles_are_within_the_bound_about_their_parabola(counted: list[str]) -> None:
    worst = float(counted[4].split()[1])
    assert 0.1 < worst <= 1


@pytest.mark.parametrize(("name", "products"), [("isolation", 1), ("far", 4)])
def test_proofs_about_points_allow_for_all_roundings(tmp_path: Path, name: str, products: int):
    """Derivatives, their products with Y, a step of Newton's method, and sums of sizes."""
    found, constants = lines_of(tmp_path, name)
    *derivatives, product, step, bounds = map(int, found.split())
    rounding, of_step, outward = (float(x) for x in constants.split())
    assert (rounding, of_step, outward) == (256, 32, 8192)
    # Products of two equations have a multiple of the constant.
    assert 15 < derivatives[0] < rounding
    assert 15 < derivatives[-1] < products * rounding
    # With those of the derivatives, or without them where both are allowed for.
    assert 10 < product < rounding
    assert 10 < step < of_step
    assert 10 < bounds < outward


def test_numbers_of_32_digits_err_by_less_than_is_allowed_for(tmp_path: Path) -> None:
    """Shifts and values of far poses, with products, and values of near ones, by 34 digits."""
    (far,), (near,) = lines_of(tmp_path, "far_fine"), lines_of(tmp_path, "near_fine")
    errors = [*map(float, far.split()), float(near)]
    for error, bound in zip(errors, (2.0**-97, 2.0**-96, 2.0**-95, 2.0**-94), strict=True):
        # Sums of many terms hardly ever err by their bounds.
        assert 2.0**-12 * bound < error < bound / 8


def test_sizes_of_numbers_are_those_before_terms_cancel(tmp_path: Path) -> None:
    """Errors are parts of the terms, however small their sum is."""
    found = [tuple(map(float, line.split())) for line in lines_of(tmp_path, "open")]
    assert [size for _, size in found] == [6, 6, 12, 16, 3, 12, 12, 18]
    assert found[0][0] == 2.0**-59
    assert [value for value, _ in found[5:]] == [0, 0, 0]


def test_derivatives_by_twists_are_within_the_bounds_of_the_controller(tmp_path: Path) -> None:
    """Of points, and of those that lines and planes of the platform see; the bounds are sharp."""
    for line in lines_of(tmp_path, "jets"):
        for worst in map(float, line.split()):
            assert 0.7 < worst <= 1 + 1e-12


def test_points_of_motors_move_within_the_bound_in_a_box_of_poses(tmp_path: Path) -> None:
    """Also those of the platform, which turn with it: to second order, and no less."""
    for line in lines_of(tmp_path, "swing"):
        slide, of_platform, worst = line.split()
        assert float(worst) <= 1 + 1e-9
        # The point of a slide of the base moves on a straight line.
        assert float(worst) > 0.5 or (slide, of_platform) == ("1", "0")
