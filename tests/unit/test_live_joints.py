"""How exactly the kernel of live pages turns joints, compiled for this processor."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import mpmath
import numpy as np
import pytest

from gspcli.certification.numbers.doubled import ERROR
from gspcli.certification.numbers.sines import SINE_ERROR, SineNumbers

ROOT = Path(__file__).resolve().parents[2]
#: What `Doubled` of open_equations.hpp leaves for the sums and products with these numbers.
PART = 4

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")


@pytest.fixture(scope="module")
def turned(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., np.ndarray]:
    path = tmp_path_factory.mktemp("joints") / "joints.so"
    module = ROOT / "viewer" / "module"
    sources = [ROOT / "tests/support/live_joints.cpp", ROOT / "native/open_equations.cpp"]
    options = ["-std=c++20", "-O1", "-shared", "-fPIC", "-ffp-contract=off", f"-I{module}"]
    subprocess.run(["g++", *options, *sources, "-o", path], check=True)
    library = ctypes.CDLL(str(path))

    def run(angle: float, degrees: bool) -> np.ndarray:
        sine = SineNumbers.of(degrees=degrees)
        head = np.concatenate((np.zeros(6 * 7), [1], np.ones(6), [1.0, degrees]))
        rest = [*sine.quarter, *sine.unit, len(sine.terms), sine.small, *np.ravel(sine.terms)]
        numbers = np.concatenate((head, rest, [SINE_ERROR, SINE_ERROR]))
        found = np.empty(5)
        data = [ctypes.c_void_p(x.ctypes.data) for x in (numbers, found)]
        library.turned(data[0], ctypes.c_double(angle), data[1])
        return found

    return run


@pytest.mark.parametrize("degrees", [True, False])
def test_joints_are_turned_with_32_digits(turned: Callable[..., np.ndarray], degrees: bool) -> None:
    most = 180.0 if degrees else np.pi
    rng = np.random.default_rng(4)
    angles = [0.0, most, -most, most / 2, -most / 2, 1e-9, -1e-300, *rng.uniform(-most, most, 400)]
    if degrees:
        angles += [360.0, -540.0, 725.5, 1e6 + 0.25, *rng.uniform(-2000, 2000, 100)]
    with mpmath.workdps(60):
        for angle in angles:
            exact = mpmath.mpf(float(angle)) * (mpmath.pi / 180 if degrees else 1)
            cosine, low_cosine, sine, low_sine, size = map(float, turned(angle, degrees))
            off = max(
                abs(mpmath.mpf(cosine) + low_cosine - mpmath.cos(exact)),
                abs(mpmath.mpf(sine) + low_sine - mpmath.sin(exact)),
            )
            assert off < ERROR * size / PART
            # Not by far: in double precision it would be.
            assert ERROR * size / PART < 2.0**-90
