"""Derive equations, degrees and loci of the ten kinds of constraint and record them in the data.

    python -m tools.data.constraints [--check]

Every recorded degree is proved to be the lowest first.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from gspcli.catalogue.bounds import varieties
from gspcli.catalogue.kinds import KINDS, Kind
from gspcli.symbolic.exact_motions import hilbert_function
from tools.equations.constraint_equations import (
    LAZARD,
    MOURRAIN,
    SYSTEMS,
    CoordinateSystem,
    equation,
    lowest_degree,
    system,
)
from tools.equations.equation_text import LATEX, TEXT, definition, why_lowest, written
from tools.equations.loci import loci
from tools.equations.lower_degrees import SPARE_POINTS, constrained_motions, excludes_degree
from tools.equations.paper_degrees import difference_degree, paper_degree
from tools.recording import ROOT, canonical_sha256, parser, report, save, versions

TARGET = ROOT / "data" / "constraints.json"
COMMAND = "python -m tools.data.constraints"
#: The degree of each block in T when R is constant.
FIXED_ORIENTATION = {"R": 0, "T": 1, "U": 1, "rho": 2, "TxR": 1}


def degree_table(kind: Kind) -> dict[str, dict[str, int]]:
    """Return the lowest degrees of a kind in each set of coordinates that can express it."""
    rows = {system.name: _degrees(kind, system.degrees) for system in SYSTEMS}
    return {name: row for name, row in rows.items() if row is not None}


def _degrees(kind: Kind, weights: Mapping[str, int]) -> dict[str, int] | None:
    """Return the degrees of one constraint, and of the difference of two where it is lower."""
    two_sided = equation(kind, weights)
    one_sided = equation(kind, weights, one_sided=True)
    difference = difference_degree(kind, weights)
    if two_sided is None or one_sided is None or difference is None:
        return None
    row = {"two_sided": two_sided[1], "one_sided": one_sided[1]}
    return row | ({"difference": difference} if difference < one_sided[1] else {})


def constraint_facts(kind: Kind) -> dict[str, Any]:
    """Derive equations, degrees and loci of one kind of constraint."""
    lowest = lowest_degree(kind)
    shown = dict.fromkeys((LAZARD, MOURRAIN, lowest.coordinates))
    return {
        "kind": kind.name,
        "definition": {"text": definition(kind), "latex": definition(kind, LATEX)},
        "equations": {coordinates.name: _equation(kind, coordinates) for coordinates in shown},
        "paper_degrees": {
            name: {
                "two_sided": paper_degree(kind, coordinates),
                "one_sided": paper_degree(kind, coordinates, one_sided=True),
            }
            for name, coordinates in (("lazard", LAZARD), ("mourrain", MOURRAIN))
        },
        "lowest": {
            "coordinates": lowest.coordinates.name,
            "two_sided": lowest.degree,
            "one_sided": lowest_degree(kind, one_sided=True).degree,
            "why": why_lowest(kind),
        },
        "degrees": degree_table(kind),
        "fixed_orientation": _degrees(kind, FIXED_ORIENTATION) if kind.is_distance else None,
        "loci": {case: asdict(locus) for case, locus in loci(kind).items()},
    }


def _equation(kind: Kind, coordinates: CoordinateSystem) -> dict[str, str]:
    found = equation(kind, coordinates.degrees)
    assert found is not None, (kind, coordinates)
    return {
        name: written(found[0], kind, coordinates, style)
        for name, style in (("text", TEXT), ("latex", LATEX))
    }


def unproved_degrees(kind: Kind, *, seed: int = 0) -> list[str]:
    """Return the recorded degrees of a kind below which another polynomial may exist.

    Parameters
    ----------
    kind
        The kind of constraint.
    seed
        Of the random instance and motions.
    """
    unproved = []
    table = degree_table(kind)
    for side in ("two_sided", "one_sided") if kind.has_sides else ("two_sided",):
        below = {name: row[side] - 1 for name, row in table.items()}
        ranks = {}
        for name, degree in below.items():
            variety = varieties()[name]
            numerator = variety.hilbert_numerator
            ranks[name] = hilbert_function(numerator, variety.dimension, degree)
        count = max(ranks.values()) + SPARE_POINTS
        motions = constrained_motions(kind, count, one_sided=side == "one_sided", seed=seed)
        unproved += [
            f"{kind} {side} in ({name}): degree {degree} is not excluded"
            for name, degree in below.items()
            if not excludes_degree(system(name), motions, degree, ranks[name])
        ]
    return unproved


def main() -> int:
    """Build or check the record; return the exit code."""
    arguments = parser(__doc__).parse_args()
    constraints = [constraint_facts(kind) for kind in KINDS]
    if unproved := [line for kind in KINDS for line in unproved_degrees(kind)]:
        return report(unproved, "")
    manifest = {
        "command": COMMAND,
        "versions": versions("sympy"),
        "sha256": canonical_sha256(constraints),
    }
    text = json.dumps(
        {"manifest": manifest, "constraints": constraints}, indent=1, ensure_ascii=False
    )
    confirmed = f"{len(constraints)} kinds of constraint, each with its lowest degrees"
    return save({TARGET: text + "\n"}, check=arguments.check, confirmed=confirmed)


if __name__ == "__main__":
    sys.exit(main())
