from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gspcli
from gspcli.export.controller.writing import controller
from gspcli.export.formats import TRIES
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import Follower, FollowerStatus, measure
from gspcli.motion.following import follower as numbers_module
from gspcli.motion.following.follower import platform_numbers
from gspcli.resources import instance_files
from tests.support.controllers.compiled import CompiledController, poses_of
from tests.support.controllers.rounding import ExactEquations
from tests.support.independent_machines import machines
from tests.support.surface_machines import tripod

STRICT = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow"]
STRICT += ["-Wdouble-promotion", "-Wstrict-prototypes", "-Werror"]
FUZZ = Path(__file__).parents[2] / "support" / "controller_fuzz.c"
#: Together all kinds, and each group of them alone.
SORTS = ["6PP", "6PL", "6DLP", "6PH", "6HP", "6DLL", "3DPP ALL ALH AHH", "DPL DLP DPH DHP DLL AHL"]
COMPILERS = [name for name in ("gcc", "clang", "clang-14") if shutil.which(name)]


def platform(kinds, seed=0):
    if kinds.startswith("@"):
        instance = gspcli.load(instance_files()[kinds[1:]])
        pose = gspcli.solve(instance).real_solutions[0]
        return instance, (pose.R.real, pose.T.real)
    return random_instance(gspcli.parse_type(kinds), np.random.default_rng(seed))


def written(instance, folder, prefix="machine", **options):
    for suffix, text in zip("hc", controller(instance, prefix, **options), strict=True):
        (folder / f"{prefix}.{suffix}").write_text(text)
    return folder / f"{prefix}.c"


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
@pytest.mark.parametrize("kinds", [*SORTS, "@reachy-mini-head"])
def test_compilers_have_nothing_to_say(kinds, tmp_path):
    source = written(platform(kinds)[0], tmp_path)
    for compiler in COMPILERS:
        subprocess.run([compiler, *STRICT, "-c", source, "-o", tmp_path / "o"], check=True)


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
def test_symbols_sizes_and_what_it_needs_of_the_library(tmp_path):
    source = written(platform("6PP")[0], tmp_path, prefix="hexapod")
    subprocess.run(["gcc", "-std=c99", "-O2", "-c", source, "-o", tmp_path / "o"], check=True)
    symbols = subprocess.run(["nm", tmp_path / "o"], check=True, capture_output=True, text=True)
    names = {(line.split()[-2], line.split()[-1]) for line in symbols.stdout.splitlines()}
    public = {name for sort, name in names if sort == "T"}
    assert public == {
        f"hexapod_{x}" for x in ("inverse", "jacobian", "start", "forward", "nearest", "text")
    }
    # Nothing that is written to, and of the library nothing but mathematics.
    assert not [name for sort, name in names if sort in "BbDdC"]
    needed = {name for sort, name in names if sort == "U"}
    allowed = {"sqrt", "atan2", "tan", "memcpy", "memmove", "memset"}
    assert needed <= allowed | {"_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}


@pytest.mark.skipif(not shutil.which("g++"), reason="no g++")
def test_the_header_is_clean_in_cpp(tmp_path):
    written(platform("6PP")[0], tmp_path)
    (tmp_path / "user.cpp").write_text(
        '#include "machine.h"\nint main() { machine_state s{}; return int(s.error); }\n'
    )
    command = ["g++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"]
    subprocess.run([*command, tmp_path / "user.cpp"], check=True)


#: The options that GCC's macros show, and the others; Clang has no macros for these, but a pragma
#: overrides them.
UNSAFE = ["-ffast-math", "-ffinite-math-only"]
UNSAFER = [
    "-funsafe-math-optimizations",
    "-fassociative-math -fno-signed-zeros -fno-trapping-math",
    "-freciprocal-math",
]


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
@pytest.mark.parametrize("options", [*UNSAFE, *UNSAFER])
def test_unsafe_arithmetic_is_refused(options, tmp_path):
    source = written(platform("6PP")[0], tmp_path)
    for compiler in COMPILERS:
        if compiler.startswith("clang") and options in UNSAFER:
            continue
        command = [compiler, "-std=c99", *options.split(), "-c", source, "-o", tmp_path / "o"]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        assert done.returncode
        assert "compile without -ffast-math" in done.stderr


@pytest.mark.skipif(not any("clang" in name for name in COMPILERS), reason="no clang")
@pytest.mark.parametrize("options", UNSAFER)
def test_clang_ignores_unsafe_options(options, tmp_path):
    source = written(platform("6PP")[0], tmp_path)
    (compiler,) = (name for name in COMPILERS if "clang" in name)
    for flags in ([], options.split()):
        command = [compiler, "-std=c99", "-O2", *flags, "-S", "-emit-llvm", source, "-o", "-"]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        code = re.sub(r" #\d+|^attributes.*$|^!.*$", "", done.stdout, flags=re.M)
        assert not re.search(r"\bf(add|mul|sub|div) (reassoc|nnan|ninf|nsz|arcp|fast|afn)", code)


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
def test_a_value_that_stays_refuses_the_poses_that_change_it(tmp_path):
    program = CompiledController(tripod(), tmp_path)
    tilted = [0.9939567578492872, 0.0981833530726402, 0.0490916765363201, 0.0]
    off = measure(tripod(), rotation_from_quaternion(np.array(tilted)), [0, 0, 4.25])[1::2]
    normals = np.array([row.base.unit for row in tripod().constraints[1::2]])
    shift = np.linalg.lstsq(normals, -np.asarray(off), rcond=None)[0]
    there = np.array([0, 0, 4.25]) + shift
    poses = np.array([[0, 0, 4.25, *tilted], [*there, *tilted]])
    values, status = program.inverse(poses)
    assert status.tolist() == [2, 0]
    assert values[1, ::2] == pytest.approx([-19.3377, 1.1980, 20.8214], abs=1e-4)
    assert np.abs(values[1, 1::2]).max() < 1e-9
    with pytest.raises(gspcli.ArgumentError, match="a value that stays is another one there"):
        Follower(tripod(), rotation_from_quaternion(np.array(tilted)), [0, 0, 4.25])


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
def test_what_is_not_finite_is_said_first(tmp_path):
    # A value that is no number is worse than another one out of its range.
    program = CompiledController(platform("@nano-hexapod")[0], tmp_path)
    pose = np.array([[0, 0, 0.09, 1, 0, 0, 0]])
    values, _ = program.inverse(pose)
    for other in (np.nan, np.inf):
        for far, bad in ((0, 5), (5, 0)):
            row = values[0].copy()
            row[far], row[bad] = -1.0, other
            assert program.follow(pose, np.stack([values[0], row])[None]).status[0, 1] == 1
            row[bad] = values[0, bad]
            assert program.follow(pose, np.stack([values[0], row])[None]).status[0, 1] == 2


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
@pytest.mark.parametrize("kinds", ["6PP", "DPL DLP DPH DHP DLL AHL", "@reachy-mini-head"])
def test_sanitizers_find_nothing(kinds, tmp_path):
    source = written(platform(kinds)[0], tmp_path)
    command = ["gcc", "-std=gnu99", "-O1", "-g", "-fsanitize=address,undefined"]
    command += ["-fno-sanitize-recover=all", "-DPREFIX=machine", f'-DSOURCE="{source}"', FUZZ]
    subprocess.run([*command, "-o", tmp_path / "fuzz", "-lm"], check=True)
    done = subprocess.run([tmp_path / "fuzz"], check=True, capture_output=True, text=True)
    counts = [int(word) for word in done.stdout.split()]
    assert counts[0] > 100
    assert counts[1] > 100


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
@pytest.mark.parametrize("kinds", ["6PP", "DPL DLP DPH DHP DLL AHL", "@reachy-mini-head"])
def test_the_program_and_the_follower_are_one(kinds, tmp_path):
    instance, (R, T) = platform(kinds)
    program = CompiledController(instance, tmp_path)
    follower = gspcli.Follower(instance, R, T)
    rng = np.random.default_rng(1)
    steps = np.abs(follower.values).max() * 2e-4 * rng.normal(size=(40, 6))
    values = follower.values + np.concatenate((np.zeros((1, 6)), steps.cumsum(axis=0)))
    start = np.concatenate((follower.T, follower.quaternion))
    walk = program.follow(start[None], values[None])
    for row, status, pose in zip(values[1:], walk.status[0, 1:], walk.poses[0, 1:], strict=True):
        found = follower.forward(row)
        assert found == status
        if found is not FollowerStatus.PROVED:
            break
        here = np.concatenate((follower.T, follower.quaternion))
        assert np.allclose(here, pose, rtol=0, atol=1e-13 * max(1, np.abs(here).max()))


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
@pytest.mark.parametrize(
    ("kinds", "far"),
    [
        ("DPP DPL DLP DPH DHP DLL", 0),
        ("3DPP ALL ALH AHH", 0),
        ("@t-top-head", 0),
        ("@hexaglide", 0),
        ("mixed", 0),
        # Legs that are long beside the platform.
        ("6PP", 400),
    ],
)
def test_derivatives_bend_as_far_as_is_said(kinds, far, tmp_path):
    if kinds == "mixed":
        machine = machines()["mixed"]()
        instance, (R, T) = machine.instance, (machine.R, machine.T)
    else:
        instance, (R, T) = platform(kinds)
    T = T + far
    program, numbers = CompiledController(instance, tmp_path), platform_numbers(instance)
    rng, n = np.random.default_rng(3), 400
    poses = np.tile(poses_of(R, T), (n, 1))
    values, _ = program.inverse(poses[:1])
    start = (values + numbers.offset) * numbers.unit + rng.normal(size=(n, 6))
    sizes = np.exp(rng.uniform(-3, 0, (n, 2)))
    twists = sizes[:, :1] * rng.normal(size=(n, 6)) / 3
    found, bound = program.bends(
        poses, twists, start, start + sizes[:, 1:] * rng.normal(size=(n, 6))
    )
    used = np.delete(bound, [k for k, kind in enumerate(numbers.kinds) if kind == "DLL"], axis=1)
    assert (used < 1e20).all()
    assert (found <= 1.001 * bound + 1e-4).all()
    # The bounds are those of the worst motion: random ones come near to them.
    assert (np.max(found / bound, axis=0) > 0.15).all()


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
def test_a_state_that_may_be_that_of_another_pose_goes_nowhere(tmp_path):
    """The error of a state bounds the distance of its pose: no other pose is within twice that."""
    instance, (R, T) = platform("6PP")
    library = CompiledController(instance, tmp_path)._library
    pose = np.ascontiguousarray(poses_of(R, T))

    def alone(error):
        # Pose, values, error; fraction, sigma, alone, steps and tries.
        state, report = np.zeros(14), np.zeros(4)
        arguments = [ctypes.c_void_p(x.ctypes.data) for x in (pose, state)]
        assert library.machine_start(*arguments, None) == FollowerStatus.PROVED
        state[13] = error
        values = state[7:13] * (1 + 1e-5)
        arguments = [ctypes.c_void_p(x.ctypes.data) for x in (values, state, report)]
        status = library.machine_forward(*arguments)
        return report[2] if status == FollowerStatus.PROVED else None

    radius = alone(0.0)
    assert radius > 0
    assert alone(0.4 * radius) == radius
    for share in (0.6, 0.9, 1.5, 3, 1e6):
        assert alone(share * radius) is None


@pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc")
@pytest.mark.parametrize("kinds", SORTS)
def test_rounding_is_within_its_bounds_and_not_nothing(kinds, tmp_path):
    flint = pytest.importorskip("flint")
    instance, (_, T) = platform(kinds)
    rng = np.random.default_rng(2)
    poses = np.concatenate((T + rng.normal(size=(20, 3)), rng.normal(size=(20, 4))), axis=1)
    program = CompiledController(instance, tmp_path)
    values, _ = program.inverse(poses)
    values *= rng.uniform(0, 2, size=values.shape)
    found = program.rounding(poses, values)
    with flint.ctx.workprec(128):
        exact = ExactEquations(instance, platform_numbers(instance))
        for pose, row, frame, place, F, J, error, slant, back in zip(
            poses, values, *found, strict=True
        ):
            for at in (pose, back):
                apart = [float(x) for x in exact.translation(frame, at)]
                assert np.linalg.norm(apart) < place / 4
            true_F, true_J = exact.at(frame, row)
            off = [abs(float(flint.arb(a) - b)) for a, b in zip(F.tolist(), true_F, strict=True)]
            assert (off < error / 4).all()
            assert np.max(off / error) > 0
            for a, b, bound in zip(J.tolist(), true_J, slant, strict=True):
                turned = [float(flint.arb(x) - y) for x, y in zip(a, b, strict=True)]
                assert np.linalg.norm(turned) < bound / 4


def test_the_header_says_what_it_is_of():
    instance, _ = platform("@nano-hexapod")
    home = gspcli.solve(instance).real_solutions[1]
    header, source = controller(instance, "nano", tries=7, home=home)
    assert "#define NANO_API 3 " in header
    assert "#define NANO_TRIES 7\n" in header
    assert re.search(r"Data: sha256 [0-9a-f]{16} ", header)
    assert "Lengths are in m, angles of values in deg" in header
    assert "1 DPP P1-B1; 2 DPP P2-B2" in header
    numbers = re.search(r"#define NANO_HOME \{\{(.*)\}, \{(.*)\}\}", header)
    assert [float(x) for x in numbers[1].split(",")] == home.T.real.tolist()
    quaternion = np.array([float(x) for x in numbers[2].split(",")])
    assert np.allclose(rotation_from_quaternion(quaternion), home.R.real, atol=1e-15)
    for text in (header, source):
        assert not re.search(r"@|HAS_|[Pp]latform_|PLATFORM_(?!CRANK)", text)
    other = gspcli.set_values(instance, ["1=0.1"])
    assert "Data: sha256" in controller(other, "nano")[0]
    assert controller(other, "nano")[0] != header
    assert controller(instance, "nano") == controller(instance, "nano")


def test_only_what_the_kinds_need_is_in_the_source():
    hexapod = controller(platform("6PP")[0], "m")[1]
    # The angle between two poses needs atan2 and tan.
    assert not re.search(r"\b(cos|sin|acos|floor)\(", hexapod)
    assert "DLL: {" not in hexapod
    lines = controller(platform("6DLL")[0], "m")[1]
    assert "bound_lines" in lines
    assert "bound_square" not in lines


@pytest.mark.parametrize("prefix", ["1st", "a-b", "", "x y", "é"])
def test_prefixes_are_names_in_c(prefix):
    with pytest.raises(gspcli.ArgumentError, match="expected a name in C"):
        controller(platform("@nano-hexapod")[0], prefix)


def test_the_template_is_what_the_numbers_are_for():
    folder = Path(numbers_module.__file__).parents[2] / "export" / "controller"
    source = (folder / "platform.c").read_text()
    # Those of slides are left out of programs that have none.
    enums = re.findall(r"enum \{ (.*) \};", source)
    kinds = ", ".join(enums).replace(" = PLATFORM_CRANK + 1", "").split(", ")
    assert tuple(kinds) == numbers_module.CONTROLLER_KINDS
    struct = source.partition("unsigned char kind[6];")[2].partition("} geometry;")[0]
    struct = re.sub(r"/\*.*?\*/|#[^\n]*", "", struct, flags=re.S)
    names = re.findall(r"(\w+)(?:\[\d\])*[,;]", struct)
    fields = list(numbers_module.PlatformNumbers.__annotations__)
    assert ["kind", *names] == fields
    assert f"#define PLATFORM_TRIES {TRIES}\n" in (folder / "platform.h").read_text()


def test_far_lines_and_planes_are_as_good_as_near_ones():
    instance, (R, T) = platform("DPL DLP DPH DHP DLL AHL")
    numbers = platform_numbers(instance)
    assert (np.linalg.norm(numbers.Y, axis=1) <= numbers.norm_y).all()
    assert numbers.reach == 2.0 ** round(np.log2(numbers.reach))
    assert (poses_of(R, T)[:3] == T).all()
