"""The page that solves: what is in it."""

from __future__ import annotations

import ctypes
import gzip
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache

import mpmath
import numpy as np
import pytest

import gspcli
from gspcli.catalogue.names import parse_type
from gspcli.certification.numbers.doubled import ERROR, SineNumbers
from gspcli.certification.numbers.rounding import COMPLEX, ISOLATED, REAL, ROUNDED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose, moved
from gspcli.geometry.enclosures import roundings
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine, driven_points
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, as_array
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.singularities.pose_clearances import Displacements, pose_clearances
from gspcli.pictures.live_numbers import (
    LiveMotors,
    _circle,
    anywhere,
    apart,
    counted,
    live_module,
    live_numbers,
    live_page,
)
from gspcli.pictures.stage import scene_of
from gspcli.resources import data_json, data_path, instance_files
from gspcli.solver import solve
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.spec import load
from tools.recording import ROOT, sha256
from viewer import kernel

#: What the page may weigh.
LIMIT = 2_000_000
ELEMENT = '<script type="{}" id="{}">(.*?)</script>'


@cache
def content(name: str) -> str:
    result = solve(load(instance_files()[name]))
    return live_page(scene_of(result), live_numbers(result), 1)


def element(text: str, name: str, kind: str = "application/json") -> str:
    found = re.search(ELEMENT.format(kind, name), text, re.DOTALL)
    assert found is not None
    return found[1]


@pytest.mark.parametrize("name", ["octahedral-3-3", "dietmaier", "example-6.8"])
def test_the_page_is_one_small_file(name: str) -> None:
    text = content(name)
    assert len(text.encode()) < LIMIT
    assert "@@" not in text
    assert re.findall("(?:src|href)=[\"']", text) == []
    assert "http:" not in written(text)
    assert "https:" not in written(text)
    assert not re.search(r"\bfetch\(|XMLHttpRequest|importScripts|WebSocket", written(text))


def test_what_the_count_rests_on_is_said() -> None:
    said = "no pose is missing is proved, wrong at most once in 10^"
    assert said in content("octahedral-3-3")
    assert "random prime" not in content("dietmaier").partition("<footer")[2]


def written(text: str) -> str:
    """Return the page without three.js, which could load textures if it were asked to."""
    start = text.index('<script type="module">')
    return text[:start]


def test_what_the_page_solves_from_is_in_it() -> None:
    text = content("octahedral-3-3")
    live = json.loads(element(text, "live"))
    assert live["values"] == [1.5, 1.8, 1.6, 1.9, 1.5, 1.7]
    assert element(text, "module", "text/plain") == live_module()
    scene = json.loads(element(text, "scene"))
    assert scene["start"] == 1
    assert len(scene["series"][0]["T"]) == 4


def test_numbers_are_there_without_a_script() -> None:
    text = content("octahedral-3-3")
    modes = text[text.index('<table id="modes">') :].partition("</table>")[0]
    assert modes.count("<tr>") == 5
    assert '<table id="constraints">' in text


# What a live page needs of a platform.


def numbers_of(name: str) -> dict:
    return live_numbers(gspcli.solve(gspcli.load(instance_files()[name])))


def test_the_module_is_that_of_the_sources():
    manifest = data_json("live", "manifest.json")
    content = gzip.decompress(data_path("live", "kernel.wasm.gz").read_bytes())
    assert manifest["module"] == {"bytes": len(content), "sha256": sha256(content)}
    hint = "run python -m viewer.kernel"
    assert manifest["manifest"]["sources"]["sha256"] == kernel.digest(), hint


def test_numbers_are_plain_data():
    found = numbers_of("nano-hexapod")
    assert json.loads(json.dumps(found)) == found
    assert found["kinds"] == ["DPP"] * 6
    assert found["sides"] == [None] * 6
    assert found["quick"]
    assert found["proof"]["by"] == "geometry count"
    assert len(found["numbers"]) < 400_000
    assert (
        found["home"] == gspcli.solve(gspcli.load(instance_files()["nano-hexapod"])).home.number - 1
    )


def test_sliders_go_through_the_ranges_of_the_file():
    instance = gspcli.load(instance_files()["rubin-m2"])
    found = live_numbers(gspcli.solve(instance))
    limits = [[x.value for x in row.limits] for row in instance.constraints]
    np.testing.assert_allclose(found["ranges"], limits)


def test_sliders_are_readings_also_with_offsets_and_scales():
    instance = gspcli.load(instance_files()["rubin-m2"])
    rows = list(instance.constraints)
    rows[0] = replace(rows[0], offset=Number.of("0.001"), scale=Number.of("0.01"))
    found = live_numbers(gspcli.solve(replace(instance, constraints=tuple(rows))))
    low, high = ((x.value - 0.001) / 1.01 for x in rows[0].limits)
    np.testing.assert_allclose(found["ranges"][0], [low, high])
    assert low < found["values"][0] < high


def test_without_ranges_they_stay_within_what_values_can_be():
    found = numbers_of("surfaces-ppp")
    for value, (low, high), kind in zip(
        found["values"], found["ranges"], found["kinds"], strict=True
    ):
        assert low < value < high
        if kind[0] == "D":
            assert low > 0
        else:
            assert low > -90
            assert high < 180
    assert found["sides"][2] is None
    assert set(found["sides"][:2]) <= {1, -1, 0}


def test_a_value_of_zero_stays():
    found = numbers_of("point-on-line")
    zero = [k for k, value in enumerate(found["values"]) if value == 0]
    assert zero
    assert all(found["ranges"][k] == [0, 0] for k in zero)


def test_limits_are_what_values_can_be():
    found = numbers_of("surfaces-ppp")
    assert found["kinds"] == ["DPH", "DHP", "DLL", "ALL", "ALH", "AHH"]
    heights, angles = [None, None], ([0, 180], [-90, 90], [0, 180])
    assert found["limits"] == [heights, heights, [0, None], *angles]


def test_what_has_no_start_is_refused():
    with pytest.raises(gspcli.GspError, match="poses for special values alone"):
        numbers_of("griffis-duffy")


def test_offsets_are_part_of_the_platform():
    instance = gspcli.load(instance_files()["rubin-m2"])
    rows = list(instance.constraints)
    rows[0] = replace(rows[0], offset=Number.of(Fraction(1, 1000)))
    shifted = replace(instance, constraints=tuple(rows))
    found = live_numbers(gspcli.solve(shifted))
    assert found["values"][0] == pytest.approx(rows[0].value.value - 1e-3, abs=1e-12)


# What a live page needs of a machine whose motors move its joints.


MACHINES = ("delta", "hexaglide", "t-top-head", "modified-paradex", "reachy-mini-head")


def machine(name: str) -> Instance:
    return gspcli.load(instance_files()[name])


@cache
def found_of(name: str) -> dict:
    return live_numbers(gspcli.solve(machine(name)))


@pytest.mark.parametrize("name", MACHINES)
def test_joints_anywhere_are_in_the_plane_or_on_the_line_of_their_motor(name: str) -> None:
    instance = machine(name)
    family, drives = anywhere(instance), Machine.of(instance)
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
    family, drives = anywhere(instance), Machine.of(instance)
    for k in range(drives.count):
        one, two = drives.users(k)
        first, second = (as_array(family.constraints[i].base.position) for i in (one, two))
        before, after = (as_array(instance.constraints[i].base.position) for i in (one, two))
        np.testing.assert_allclose(second - first, after - before, atol=1e-9)


def test_motors_that_are_held_leave_their_joints() -> None:
    instance = machine("t-top-head")
    names = Machine.of(instance).names
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
    drives = Machine.of(instance)
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
    drives = Machine.of(alone)
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


# The pages of `gsp view`: what they are made of.


SOURCES = ROOT / "viewer"
VIEW = ROOT / "data" / "view"
NAMES = ("page.html", "live.html")
STYLES = {"page.html": ("style.css",), "live.html": ("style.css", "live.css")}


@pytest.mark.parametrize("name", NAMES)
def test_the_page_is_of_the_present_sources(name: str) -> None:
    text = (VIEW / name).read_text(encoding="utf-8")
    for style in STYLES[name]:
        assert (SOURCES / "src" / style).read_text(encoding="utf-8").strip() in text
    before, _, rest = (SOURCES / "src" / name).read_text("utf-8").partition("@@style@@")
    between = re.split("@@(?:worker|script)@@", rest)[0]
    assert text.startswith(before)
    assert between in text


@pytest.mark.parametrize("name", NAMES)
def test_the_licence_of_three_is_in_every_copy(name: str) -> None:
    licence = (VIEW / "LICENSE.three.txt").read_text(encoding="utf-8").strip()
    assert licence.startswith("The MIT License")
    assert licence in (VIEW / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_page_may_not_ask_for_anything(name: str) -> None:
    text = (VIEW / name).read_text(encoding="utf-8")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy
    assert "default-src 'none'" in policy[1]
    assert "http" not in policy[1]
    assert "'unsafe-eval'" not in policy[1]


# How exactly the kernel of live pages turns joints, compiled for this processor.


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
        numbers = np.concatenate((head, rest, [ERROR, ERROR]))
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


# The kernel of live pages, built again.


@pytest.mark.skipif(shutil.which(kernel.COMPILER) is None, reason="no emscripten here")
def test_the_module_is_built_again():
    version = kernel.compiler()
    kept = kernel.kept()
    if version != kept["manifest"]["compiler"]:
        pytest.skip(f"{version} makes another module than {kept['manifest']['compiler']}")
    assert kernel.module(2) == gzip.decompress(kernel.KEPT.read_bytes())


# The proofs of the kernel of live pages, compiled for this processor, and those of the package.


MODULE = ROOT / "viewer" / "module"
#: As the kernel of a page numbers them; the others are angles.
KINDS = ("DPP", "DPL", "DLP", "DPH", "DHP", "DLL")


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
    found.clearance.restype = found.far_deviation.restype = ctypes.c_double
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


@pytest.mark.parametrize(("far", "scale", "error"), [(4, 1, 4), (1, 1, 1), (1, 4, 1), (8, 4, 2)])
def test_errors_of_poses_far_away_are_in_the_unit_of_the_others(
    library: ctypes.CDLL, far: float, scale: float, error: float
) -> None:
    """Of translations; those of rotations have no unit and stay."""
    assert library.far_deviation(ctypes.c_double(far), ctypes.c_double(scale)) == error


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
    data = np.concatenate((head, [1, 1e-9, 1, 1], line, [roundings(8, 1.0)]))

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
