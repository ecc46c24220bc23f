"""Rounding is bounded in one type. Constants of rounding elsewhere are in this list, which shrinks.

A proof is plain formulas over `gspcli.geometry.enclosures`: a constant that is derived by hand is
one that nobody can audit. Whoever needs one writes down why.
"""

from __future__ import annotations

import re
from pathlib import Path

import gspcli

ROOT = Path(gspcli.__file__).parent
NATIVE = Path(__file__).parents[2] / "native"
TYPE = "geometry/enclosures.py"
#: Literal powers, and names of factors and errors.
CONSTANT = re.compile(
    r"\b2\.0 ?\*\* ?-\d"
    r"|^_?(?:OUTWARD|INWARD|ROUNDING|ROUNDED|UP|DOWN)\b.* = (?!.*2\.0 ?\*\* ?-\d|\()"
    r"|^from gspcli\.geometry\.enclosures import (?:\([^)]*|.*)\b(?:OUT|ROUND|TINY)\b",
    re.MULTILINE,
)
#: How many constants of rounding there may be.
MOST = 10
#: Of each file: how many bounds of rounding, which a proof relies on, and why.
BOUNDS = {
    "certification/numbers/doubled.py": (1, "numbers and sines as sums of two doubles"),
    "certification/numbers/rounding.py": (
        3,
        "the nearest double; two of the kernel, counted there",
    ),
}
#: What rounding of doubles may do where nothing is proved.
DOUBLES = {
    "continuation/tracker.py": (1, "residuals and coefficients, of what is clearly simple"),
    "geometry/machine.py": (1, "readings at the end of a range"),
    "geometry/measurement.py": (1, "singular values that may be zero, as NumPy's rank has it"),
    "motion/following/tracks.py": (1, "poses that are compared, by their condition number"),
    "motion/workspace/workspaces.py": (1, "sums of volumes"),
}
#: No rounding: what people type, and where searches stop. A wrong one proves nothing wrong.
OTHERS = {
    "certification/branches/curves.py": (3, "where Newton's method and arcs stop; widths to try"),
    "certification/equations/local_frames.py": (1, "the least scale, a power of two"),
    "certification/poses/far_points.py": (2, "digits that are asked for"),
    "certification/poses/far_poses.py": (2, "digits that are asked for, and steps"),
    "certification/poses/locator.py": (2, "where a search gives up"),
    "certification/poses/multiple.py": (3, "where Newton's method stops, with 1024 bits"),
    "geometry/checking.py": (1, "masses as they are typed"),
    "motion/files/pose_files.py": (1, "rotations and values as they are typed"),
    "motion/following/follower.py": (1, "the shortest step"),
    "motion/paths/between.py": (1, "the shortest piece"),
}
#: Negative powers of two in the kernel, by file: how many, and why. Those that are counted run with
#: numbers that count roundings, and those that are sampled beside more digits
#: (`tests/unit/motion/following/test_roundings.py`).
KERNEL = {
    "box_forms.hpp": (1, "sums of intervals of the type"),
    "correct_rounding.hpp": (7, "sampled; steps of the grid of rounded numbers"),
    "drives.hpp": (3, "directions to points, some operations; bounds from below"),
    "drives.cpp": (1, "no proof: places without an order"),
    "ends.cpp": (1, "sampled: values with 32 digits"),
    "far_poses.cpp": (6, "sampled: shifts and values with 32 digits; no proof: where paths stop"),
    "fine_far_poses.cpp": (3, "sampled: forms with 32 digits"),
    "fine_points.cpp": (1, "a bound from below"),
    "gaps.cpp": (2, "distances of hulls, beside exact ones in their tests"),
    "inverse.hpp": (5, "counted: derivatives, products, sums of sizes, steps"),
    "pose_box.hpp": (1, "sines of the C library"),
    "reach.cpp": (1, "a bound from below"),
    "reach.hpp": (4, "the type of intervals: one rounding, its sums, and the least number"),
    "reach_module.cpp": (2, "corners of boxes, as wide as they may be computed elsewhere"),
    "branch_follower.cpp": (1, "ends of segments of one mode"),
    "segment_proof.hpp": (5, "counted: values, gradients, products; a sampled parabola"),
    "tracker.cpp": (2, "no proof: digits of long series"),
}


def test_no_file_has_more_constants_of_rounding_than_are_listed() -> None:
    found = {}
    for room in ("certification", "continuation", "geometry", "motion"):
        for path in sorted((ROOT / room).rglob("*.py")):
            count = len(CONSTANT.findall(path.read_text("utf-8")))
            if count and (name := path.relative_to(ROOT).as_posix()) != TYPE:
                found[name] = count
    assert found == {name: count for name, (count, _) in (BOUNDS | DOUBLES | OTHERS).items()}


def test_there_are_few_constants_of_rounding() -> None:
    assert sum(count for count, _ in (BOUNDS | DOUBLES).values()) <= MOST


def test_powers_of_two_in_the_kernel_are_listed() -> None:
    found = {}
    for path in sorted(NATIVE.iterdir()):
        if count := len(re.findall(r"0x1p-\d", re.sub("//.*", "", path.read_text("utf-8")))):
            found[path.name] = count
    assert found == {name: count for name, (count, _) in KERNEL.items()}
