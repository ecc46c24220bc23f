"""Rounding is bounded in one type. Constants of rounding elsewhere are in this list, which shrinks.

A proof is plain formulas over `gspcli.geometry.enclosures`: a constant that is derived by hand is
one that nobody can audit. Whoever needs one writes down why.
"""

from __future__ import annotations

import re
from pathlib import Path

import gspcli

ROOT = Path(gspcli.__file__).parent
TYPE = "geometry/enclosures.py"
#: Literal powers, and names of factors and errors.
CONSTANT = re.compile(
    r"\b2\.0 ?\*\* ?-\d"
    r"|^_?(?:OUTWARD|INWARD|ROUNDING|ROUNDED|UP|DOWN)\b.* = (?!.*2\.0 ?\*\* ?-\d)"
    r"|^from gspcli\.geometry\.enclosures import .*\b(?:OUT|ROUND|TINY)\b",
    re.MULTILINE,
)
#: How many bounds of rounding may be derived by hand.
MOST = 10
#: Of each file: how many bounds of rounding, which a proof relies on, and why.
BOUNDS = {
    "certification/numbers/correct_rounding.py": (1, "half of the last place, less 2^-55"),
    "certification/numbers/doubled.py": (2, "numbers and sines as sums of two doubles"),
    "certification/numbers/rounding.py": (3, "factors of the kernel, which counts its roundings"),
    "certification/poses/collection.py": (1, "what is rounded correctly"),
    "certification/poses/far_poses.py": (1, "what is lost where doubles underflow"),
    "certification/poses/locator.py": (1, "half of the last place"),
    "motion/singularities/neighbourhoods.py": (1, "norms and the Kantorovich number"),
}
#: Numbers on which no proof relies: a wrong one makes a search stop early, or shows other digits.
OTHERS = {
    "certification/branches/arcs.py": (5, "where Newton's method and arcs stop; widths to try"),
    "certification/branches/folds.py": (3, "where Newton's method stops; widths to try"),
    "certification/equations/local_frames.py": (1, "the least scale"),
    "certification/poses/far_points.py": (2, "digits that are asked for"),
    "certification/poses/far_poses.py": (3, "digits that are asked for, and steps"),
    "certification/poses/locator.py": (2, "where a search gives up"),
    "certification/poses/many_values.py": (1, "a bit of a mask"),
    "certification/poses/multiple.py": (3, "where Newton's method stops"),
    "continuation/endpoints.py": (1, "steps of Newton's method"),
    "geometry/checking.py": (1, "masses as they are typed"),
    "geometry/limits.py": (1, "readings at the end of a range"),
    "geometry/measurement.py": (2, "residuals that are printed"),
    "motion/files/pose_files.py": (1, "rotations as they are typed"),
    "motion/files/value_files.py": (1, "values as they are typed"),
    "motion/following/tracks.py": (1, "poses as they are typed"),
    "motion/following/followed_rows.py": (1, "the shortest step"),
    "motion/following/platform_numbers.py": (1, "readings at the end of a range"),
    "motion/paths/between.py": (1, "the shortest piece"),
    "motion/statics/wrenches.py": (1, "forces that are printed"),
    "motion/workspace/travels.py": (1, "the smallest interval"),
    "motion/workspace/workspaces.py": (1, "volumes that are printed"),
}


def test_no_file_has_more_constants_of_rounding_than_are_listed() -> None:
    found = {}
    for room in ("certification", "continuation", "geometry", "motion"):
        for path in sorted((ROOT / room).rglob("*.py")):
            count = len(CONSTANT.findall(path.read_text("utf-8")))
            if count and (name := path.relative_to(ROOT).as_posix()) != TYPE:
                found[name] = count
    none = (0, "")
    listed = {
        name: BOUNDS.get(name, none)[0] + OTHERS.get(name, none)[0] for name in BOUNDS | OTHERS
    }
    assert found == listed


def test_few_bounds_are_derived_by_hand() -> None:
    assert sum(count for count, _ in BOUNDS.values()) <= MOST
