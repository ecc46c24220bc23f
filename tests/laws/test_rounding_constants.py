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
#: Of each file: how many, and why.
LISTED = {
    # Numbers of more than 53 bits, and what is sampled against balls of arb.
    "certification/branches/arcs.py": (6, "widths of Krawczyk's test, in balls"),
    "certification/branches/folds.py": (3, "widths of Krawczyk's test, in balls"),
    "certification/numbers/correct_rounding.py": (1, "half of the last place, less 2^-55"),
    "certification/numbers/doubled.py": (2, "sums of two doubles"),
    "certification/numbers/rounding.py": (4, "factors of the kernel, which counts its roundings"),
    "certification/poses/collection.py": (1, "what is rounded correctly"),
    "certification/poses/far_points.py": (2, "digits that are asked for: no bound"),
    "certification/poses/far_poses.py": (5, "distances and digits that are asked for, in balls"),
    "certification/poses/locator.py": (3, "digits that are asked for: no bound"),
    "certification/poses/multiple.py": (3, "digits that are asked for: no bound"),
    # Constants of loops with lanes in the kernel: its roundings are counted.
    "certification/branches/parametric_quadrics.py": (2, "entries of Hessian matrices"),
    "certification/equations/local_frames.py": (1, "a part of a scale: no bound"),
    "motion/following/followed_rows.py": (2, "frames of the step, and its shortest part"),
    "motion/following/platform_numbers.py": (2, "numbers of the controller in C"),
    # Not proofs.
    "geometry/limits.py": (2, "readings at the end of a range"),
    "geometry/checking.py": (1, "masses as they are typed"),
    "geometry/printed_numbers.py": (1, "digits that are printed"),
    "geometry/residuals.py": (2, "residuals that are printed"),
    "motion/files/pose_files.py": (1, "rotations as they are typed"),
    "motion/files/value_files.py": (1, "values as they are typed"),
    "certification/poses/many_values.py": (1, "a bit of a mask: no bound"),
    "continuation/endpoints.py": (1, "steps of Newton's method"),
    "motion/following/tracks.py": (1, "poses as they are typed"),
    "motion/singularities/scans.py": (1, "a step of differences"),
    "motion/statics/wrenches.py": (1, "forces that are printed"),
    "motion/workspace/travels.py": (1, "the smallest interval: no bound"),
    "motion/workspace/workspaces.py": (1, "volumes that are printed"),
    # What the constants of the type are used for elsewhere.
    "motion/paths/guides.py": (1, "half widths of boxes"),
    "motion/paths/value_ways.py": (1, "half widths of boxes"),
    "motion/singularities/neighbourhoods.py": (1, "norms and the Kantorovich number"),
    "motion/singularities/pose_clearances.py": (1, "the theorem of Perron and Frobenius"),
    "motion/statics/accuracy.py": (1, "entries of a quadric"),
    # To be converted.
    "motion/collisions/compared.py": (4, "sums of moduli"),
    "motion/paths/between.py": (4, "half widths of boxes, the shortest piece, and a quotient"),
    "motion/workspace/pose_boxes.py": (3, "half widths of boxes, readings at the end of a range"),
}


def test_no_file_has_more_constants_of_rounding_than_are_listed() -> None:
    found = {}
    for room in ("certification", "continuation", "geometry", "motion"):
        for path in sorted((ROOT / room).rglob("*.py")):
            count = len(CONSTANT.findall(path.read_text("utf-8")))
            if count and (name := path.relative_to(ROOT).as_posix()) != TYPE:
                found[name] = count
    more = {name: n for name, n in found.items() if n > LISTED.get(name, (0, ""))[0]}
    assert more == {}
