"""Round trips through LinuxCNC's kinematics module of docs/controller.

The module is built by LinuxCNC's own ``halcompile`` (Debian: linuxcnc-uspace-dev) and loaded into
this process. Its inverse kinematics turn worlds (x, y, z, a, b, c) into joints, and its forward
kinematics turn these back. Worlds move straight away from home, by 1 % of the size or a hundredth
of a radian a step, or less where the joints would leave their ranges. A walk ends where it is
refused, and where a crank does not reach the world (no joints). Beyond a singular pose worlds are
on another branch than home, and joints do not tell branches apart: they are not compared.
"""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.defaults import SEED
from gspcli.export.controller.writing import controller
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.following.follower import platform_numbers
from gspcli.solver import Solution
from tests.support.controllers.compiled import CompiledController, poses_of
from tools.recording import ROOT

Array = NDArray[np.float64]
PLATFORMS = ROOT / "data" / "platforms"
EXAMPLE = ROOT / "docs" / "controller" / "provedkins.c"
HAL = Path(__file__).parent / "linuxcnc_hal.c"
HEADERS = Path("/usr/include/linuxcnc")
#: Rows of a walk, and the size of a step.
ROWS, STEP = 100, 0.01
#: How often steps are halved until joints stay in their ranges.
SHORTER = 40


@dataclass
class Row:
    """The results for the worlds of one machine."""

    name: str
    worlds: int = 0
    compared: int = 0
    refused: int = 0
    beyond: int = 0
    without_joints: int = 0
    difference: float = 0.0


def build_module(instance: Instance, home: Solution, folder: Path) -> Path:
    """Build the module of a machine with LinuxCNC's own program, and return its file."""
    for suffix, text in zip("hc", controller(instance, "hexapod", home=home), strict=True):
        (folder / f"hexapod.{suffix}").write_text(text, encoding="utf-8")
    shutil.copy(EXAMPLE, folder)
    command = ["halcompile", "--compile", "--extra-compile-args=-std=gnu99", EXAMPLE.name]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "provedkins.so"


@cache
def hal() -> ctypes.CDLL:
    """Return what stands for LinuxCNC's HAL in this process, for all modules."""
    with tempfile.TemporaryDirectory() as folder:
        library = f"{folder}/libhal.so"
        command = ["cc", "-std=gnu99", "-O2", "-DULAPI", f"-I{HEADERS}", "-fPIC", "-shared"]
        subprocess.run([*command, str(HAL), "-o", library], check=True)
        return ctypes.CDLL(library, mode=ctypes.RTLD_GLOBAL)


class Kinematics:
    """The kinematics of a module, in this process."""

    def __init__(self, module: Path) -> None:
        self._hal = hal()
        self._module = ctypes.CDLL(str(module), mode=ctypes.RTLD_LOCAL)
        if self._module.rtapi_app_main():
            raise RuntimeError("the module does not start")

    def round_trips(self, worlds: Array) -> tuple[Array, Array, NDArray[np.int32]]:
        """Walk through worlds, shape (n, r, 6).

        Returns
        -------
        tuple
            Joints, the worlds that they lead to, both (n, r, 6), and 0, 1 (no joints) or 2
            (refused), shape (n, r), where a walk ends and after it.
        """
        worlds = np.ascontiguousarray(worlds)
        joints, back = np.zeros(worlds.shape), np.full(worlds.shape, np.nan)
        status = np.zeros(worlds.shape[:2], np.int32)
        self._hal.round_trips(
            self._module.kinematicsInverse,
            self._module.kinematicsForward,
            *map(ctypes.c_long, status.shape),
            *(ctypes.c_void_p(x.ctypes.data) for x in (worlds, joints, back, status)),
        )
        return joints, back, status


def rotations(worlds: Array) -> Array:
    """Return R = Rz(c) Ry(b) Rx(a) of worlds in degrees, shape (..., 3, 3)."""
    a, b, c = np.moveaxis(np.radians(worlds[..., 3:]), -1, 0)
    one = [np.zeros((*a.shape, 3)) for _ in range(3)]
    for vector, axis, angle in zip(one, range(3), (a, b, c), strict=True):
        vector[..., axis] = angle
    x, y, z = map(rotation_from_vector, one)
    found: Array = z @ y @ x
    return found


def walk_poses(home: Solution, size: float, steps: Array) -> tuple[Array, Array]:
    """Return poses of walks straight from home, by twists a step, shape (n, 6)."""
    twists = np.arange(ROWS)[:, None] * steps[:, None]
    R: Array = rotation_from_vector(twists[..., :3]) @ home.R.real
    return R, home.T.real + size * twists[..., 3:]


def within_ranges(
    program: CompiledController, home: Solution, size: float, steps: Array, limits: Array
) -> Array:
    """Return steps, shortened so that joints stay in their ranges, limits of shape (2, 6)."""
    steps = steps.copy()
    for _ in range(SHORTER):
        values, _ = program.inverse(poses_of(*walk_poses(home, size, steps)).reshape(-1, 7))
        values = values.reshape(len(steps), ROWS, 6)
        outside = ((values < limits[0]) | (values > limits[1])).any(axis=(1, 2))
        if not outside.any():
            return steps
        steps[outside] /= 2
    steps[outside] = 0
    return steps


def worlds_of(R: Array, T: Array) -> Array:
    """Return (x, y, z, a, b, c) of poses, angles in degrees."""
    a = np.arctan2(R[..., 2, 1], R[..., 2, 2])
    b = np.arcsin(np.clip(-R[..., 2, 0], -1, 1))
    c = np.arctan2(R[..., 1, 0], R[..., 0, 0])
    return np.concatenate((T, np.degrees(np.stack((a, b, c), axis=-1))), axis=-1)


def examine(each: int, name: str) -> Row:
    """Make the round trips of one machine."""
    instance = gspcli.load(PLATFORMS / f"{name}.yaml")
    result = gspcli.solve(instance)
    assert result.home is not None
    home = result.real_solutions[result.home.number - 1]
    numbers = platform_numbers(instance)
    size = float(numbers.reach)
    rng = np.random.default_rng((SEED, *name.encode()))
    steps = rng.normal(size=(math.ceil(each / ROWS), 6))
    steps *= STEP / np.linalg.norm(steps, axis=1, keepdims=True)
    with tempfile.TemporaryDirectory() as folder:
        program = CompiledController(instance, Path(folder))
        limits = np.array([numbers.least, numbers.most]) - numbers.offset
        R, T = walk_poses(home, size, within_ranges(program, home, size, steps, limits))
        worlds = worlds_of(R, T)
        kinematics = Kinematics(build_module(instance, home, Path(folder)))
        joints, back, status = kinematics.round_trips(worlds)
        J, _ = program.jacobian(poses_of(R, T).reshape(-1, 7), joints.reshape(-1, 6))
    sides = np.sign(np.linalg.det(J)).reshape(status.shape)
    here = np.logical_and.accumulate(sides == sides[:, :1], axis=1)
    turned = np.abs(rotations(back) - rotations(worlds)).max(axis=(2, 3))
    moved = np.linalg.norm(back[..., :3] - worlds[..., :3], axis=2) / size
    compared = (status == 0) & here
    worst = float(np.maximum(turned, moved)[compared].max(initial=0))
    return Row(
        name,
        status.size,
        int(compared.sum()),
        int((status[:, -1] == 2).sum()),
        int(((status == 0) & ~here).sum()),
        int((status == 1).sum()),
        10.0 ** math.ceil(math.log10(worst)) if worst else 0.0,
    )
