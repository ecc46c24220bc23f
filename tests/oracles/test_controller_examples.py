"""The examples of docs/controller.md, compiled and run, where their tools are.

The one for LinuxCNC is in test_linuxcnc.py.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

import gspcli
from gspcli.export.controller.writing import controller
from gspcli.resources import instance_files

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "docs" / "controller"
SUPPORT = ROOT / "tests" / "support"
STRICT = ["-O2", "-Wall", "-Wextra", "-Werror"]
HOMES = {"nano-hexapod": [0, 0, 0.09]}


def needs(*programs):
    absent = [name for name in programs if not shutil.which(name)]
    return pytest.mark.skipif(bool(absent), reason=f"no {', '.join(absent)}")


def export(name, prefix, folder, **options):
    """The program of a machine, from the pose at which it is in its file."""
    instance = gspcli.load(instance_files()[name])
    home = min(
        gspcli.solve(instance).real_solutions,
        key=lambda pose: (
            abs(pose.T.real - HOMES[name]).max()
            + abs(pose.R.real - [[1, 0, 0], [0, 1, 0], [0, 0, 1]]).max()
        ),
    )
    for suffix, text in zip("hc", controller(instance, prefix, home=home, **options), strict=True):
        (folder / f"{prefix}.{suffix}").write_text(text)


def run(*command, cwd):
    subprocess.run([str(word) for word in command], check=True, cwd=cwd)


def said(*command, cwd):
    done = subprocess.run(
        [str(word) for word in command],
        check=True,
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=60,
    )
    return done.stdout


@needs("gcc")
def test_loop(tmp_path):
    export("nano-hexapod", "nano_hexapod", tmp_path)
    run(
        "gcc",
        "-std=c99",
        *STRICT,
        f"-I{tmp_path}",
        EXAMPLES / "loop.c",
        "nano_hexapod.c",
        "-lm",
        "-o",
        "loop",
        cwd=tmp_path,
    )
    assert said("./loop", cwd=tmp_path).startswith("lifted to z = 0.091000 m, exact within ")


@needs("gcc")
def test_loop_goes_on_in_shorter_steps(tmp_path):
    # One try a step: what one step does not prove sixteen do, and what is beyond a fold none.
    export("nano-hexapod", "nano_hexapod", tmp_path, tries=1)
    (tmp_path / "user.c").write_text(
        """
#define main loop
#include "loop.c"
#undef main
int main(void) {
  const nano_hexapod_pose home = NANO_HEXAPOD_HOME;
  nano_hexapod_pose goal = home;
  nano_hexapod_state state, once;
  double values[6], far[6];
  int k;
  if (nano_hexapod_start(&home, &state, 0)) return 1;
  goal.position[2] += 0.02, goal.rotation[1] += 0.1;
  nano_hexapod_inverse(&goal, values);
  once = state;
  printf("%s; ", nano_hexapod_text(nano_hexapod_forward(values, &once, 0)));
  printf("%s; ", nano_hexapod_text(advance(values, &state, 0)));
  printf("%d; ", (int)(1e6 * state.pose.position[2] + 0.5));
  for (k = 0; k < 6; ++k) far[k] = state.values[k] + (k % 2 ? -0.1 : 0.1);
  printf("%d; ", advance(far, &state, 0) != NANO_HEXAPOD_PROVED);
  far[0] = 0.0 / 0.0;
  printf("%s; %s", nano_hexapod_text(advance(far, &state, 0)), nano_hexapod_text(7));
  return 0;
}
"""
    )
    run(
        "gcc",
        "-std=c99",
        *STRICT,
        "-Wno-div-by-zero",
        f"-I{tmp_path}",
        f"-I{EXAMPLES}",
        "user.c",
        "nano_hexapod.c",
        "-lm",
        "-o",
        "user",
        cwd=tmp_path,
    )
    assert said("./user", cwd=tmp_path) == (
        "refused: the line of values is too long; proved; 110000; 1; "
        "an argument is not finite, or a quaternion is zero; no status"
    )


@needs("gcc", "ar", "rustc")
def test_rust(tmp_path):
    export("nano-hexapod", "nano_hexapod", tmp_path)
    run("gcc", "-std=c99", *STRICT, "-c", "nano_hexapod.c", cwd=tmp_path)
    run("ar", "rcs", "libnano_hexapod.a", "nano_hexapod.o", cwd=tmp_path)
    run(
        "rustc",
        "--edition",
        "2021",
        "-O",
        EXAMPLES / "follow.rs",
        "-L",
        ".",
        "-l",
        "static=nano_hexapod",
        "-l",
        "m",
        cwd=tmp_path,
    )
    assert said("./follow", cwd=tmp_path).startswith("lifted to z = 0.091000 m, exact within ")


@needs("arm-none-eabi-gcc", "qemu-system-arm")
def test_teensy_sketch_on_an_emulated_cortex_m7(tmp_path):
    export("nano-hexapod", "nano_hexapod", tmp_path)
    board = SUPPORT / "cortex_m"
    cpu = [
        "-mcpu=cortex-m7",
        "-mthumb",
        "-mfpu=fpv5-d16",
        "-mfloat-abi=hard",
        "-O2",
        "-Wall",
        "-Wextra",
    ]
    run("arm-none-eabi-gcc", *cpu, "-std=c99", "-Werror", "-c", "nano_hexapod.c", cwd=tmp_path)
    run("arm-none-eabi-gcc", *cpu, "-c", board / "board.c", "-o", "board.o", cwd=tmp_path)
    run(
        "arm-none-eabi-gcc",
        *cpu,
        "-std=c++11",
        "-fno-exceptions",
        "-fno-rtti",
        f"-I{EXAMPLES}",
        f"-I{tmp_path}",
        "-x",
        "c++",
        "-c",
        board / "sketch.cpp",
        "-o",
        "sketch.o",
        cwd=tmp_path,
    )
    run(
        "arm-none-eabi-gcc",
        *cpu,
        "-nostartfiles",
        f"-T{board / 'link.ld'}",
        "board.o",
        "sketch.o",
        "nano_hexapod.o",
        "-lm",
        "-o",
        "sketch.elf",
        cwd=tmp_path,
    )
    qemu = [
        "qemu-system-arm",
        "-machine",
        "mps2-an500",
        "-icount",
        "shift=0",
        "-nographic",
        "-monitor",
        "none",
        "-serial",
        "none",
    ]
    board_says = ["-semihosting-config", "enable=on,target=native", "-kernel", "sketch.elf"]
    done = subprocess.run(
        [*qemu, *board_says], check=True, cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    lines = (done.stdout + done.stderr).split()
    assert lines[0] == "91000"
    one, refused, tries = map(int, lines[1:])
    # The number of instructions is bounded for any values; docs/controller.md has the bound.
    assert 1000 < one < 20000
    assert one < refused < (tries + 1) * 40000
