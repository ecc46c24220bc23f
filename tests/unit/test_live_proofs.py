"""The proofs of the kernel of live pages, compiled for this processor, and those of the package."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.certification.numbers.rounding import COMPLEX, ISOLATED, REAL, ROUNDED, ROUNDING
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.singularities.pose_clearances import Displacements, pose_clearances

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "viewer" / "module"
#: As the kernel of a page numbers them; the others are angles.
KINDS = ("DPP", "DPL", "DLP", "DPH", "DHP", "DLL")

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    path = tmp_path_factory.mktemp("live") / "live.so"
    sources = [
        ROOT / "tests/support/live_proofs.cpp",
        MODULE / "clearance.cpp",
        MODULE / "proofs.cpp",
    ]
    # Only what is called is linked.
    options = [
        "-std=c++20",
        "-O1",
        "-shared",
        "-fPIC",
        "-fvisibility=hidden",
        "-ffunction-sections",
    ]
    options += ["-fvisibility-inlines-hidden", "-Wl,--gc-sections", f"-I{MODULE}"]
    subprocess.run(["g++", *options, *sources, "-o", path], check=True)
    found = ctypes.CDLL(str(path))
    found.clearance.restype = ctypes.c_double
    return found


def pointer(values: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(values.ctypes.data)


@pytest.mark.parametrize(
    "kinds", ["6PP", "6DPL", "6DLP", "3PP 3PH", "3PP 3HP", "4PP 2DLL", "4PP ALL AHL", "3DPL 3DLP"]
)
def test_clearances_are_those_of_the_package(library: ctypes.CDLL, kinds: str) -> None:
    rng = np.random.default_rng(1)
    instance, (R, T) = random_instance(parse_type(kinds), rng)
    home = Displacements(instance, np.eye(3)[None], np.zeros((1, 3)))
    given = Arrangement.of(instance)
    numbers = [KINDS.index(kind.name) if kind.name in KINDS else len(KINDS) for kind in given.kinds]
    parts = [given.y, given.x, given.u, given.v, home.centre, home.axes[0], home.radii]
    data = np.concatenate([numbers, *(np.ravel(part) for part in parts)]).astype(float)
    clear = 0
    for _ in range(6):
        R, T = rotation_from_vector(0.2 * rng.normal(size=3)) @ R, T + 0.2 * rng.normal(size=3)
        pose = np.concatenate((R.ravel(), T))
        found = library.clearance(pointer(data), pointer(pose))
        wanted = pose_clearances(instance, R, T)[0]
        clear += wanted > 0
        # A radius is sought up to a percent.
        assert found == pytest.approx(wanted, rel=0.011)
    assert clear


def test_poses_are_different_only_beyond_both_bounds(library: ctypes.CDLL) -> None:
    pose = np.random.default_rng(2).normal(size=12)

    def different(gap: float, bounds: list[float], *, entry: int, scale: float = 1.0) -> bool:
        entries = np.array([pose, pose])
        entries[1, entry] += gap
        arguments = pointer(entries), pointer(np.array(bounds)), ctypes.c_double(scale)
        return bool(library.different(2, *arguments))

    for entry in (0, 8, 9, 11):
        assert different(3e-6, [1e-6, 1e-6], entry=entry)
        for bounds in ([1e-6, 1e-6], [1.9e-6, 1e-9], [1e-9, 1.9e-6]):
            assert not different(1.5e-6, bounds, entry=entry)
    # Of translations bounds are in units of the scale.
    assert not different(3e-6, [1e-6, 1e-6], entry=9, scale=2.0)
    assert different(3e-6, [1e-6, 1e-6], entry=0, scale=2.0)
    assert not different(0.0, [0.0, 0.0], entry=0)


def test_a_pose_is_proved_to_be_alone_and_real_or_not(library: ctypes.CDLL) -> None:
    assert library.is_pose(ISOLATED | REAL)
    assert library.is_pose(ISOLATED | COMPLEX | ROUNDED)
    for bits in (0, ISOLATED, REAL, COMPLEX, ISOLATED | ROUNDED, REAL | ROUNDED):
        assert not library.is_pose(bits)


@pytest.fixture
def skew(library: ctypes.CDLL) -> Callable[[np.ndarray, float], bool]:
    """Whether two lines along x are proved not to be parallel, at a rotation and its error."""
    line = np.zeros(9)
    line[0] = 1
    head = np.concatenate(([0], np.full(18, -1.0), np.zeros(24), np.full(6, -1.0), np.zeros(6)))
    data = np.concatenate((head, [1, 1e-9, 1, 1], line, [ROUNDING]))

    def asked(R: np.ndarray, deviation: float) -> bool:
        rotation = np.ascontiguousarray(R.ravel())
        return bool(library.skew(pointer(data), pointer(rotation), ctypes.c_double(deviation)))

    return asked


def test_lines_that_may_be_parallel_are_not_proved_skew(
    skew: Callable[[np.ndarray, float], bool],
) -> None:
    """The cosine of an angle a is about 1 - a^2 / 2; its square is known within twice the error."""
    for angle in (1e-3, 0.1, 1.0):
        R = rotation_from_vector(np.array([0, 0, angle]))
        assert skew(R, 0.4 * angle**2 / 2 * np.sinc(angle / np.pi) ** 2)
        for share in (1.05, 1.5, 3):
            assert not skew(R, share * (1 - np.cos(angle)))
    assert not skew(np.eye(3), 0.0)
    assert not skew(np.eye(3) * np.nan, 0.0)
