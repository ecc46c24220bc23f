"""Compute dimension and degree of the rigid-motion varieties and record them in the data.

    python -m tools.data.varieties [--check]

The degree is that of the projective closure. A Gröbner basis for an ordering by total degree needs
no homogenization: its leading monomials are those of the homogenized, saturated ideal. Done with
Singular (Debian: ``apt-get install singular``) over the rationals and modulo two primes, which must
agree.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from tools.equations.constraint_equations import SYSTEMS, CoordinateSystem
from tools.equations.motions import equations
from tools.oracle import singular
from tools.recording import ROOT, canonical_sha256, parser, save, versions

TARGET = ROOT / "data" / "varieties.json"
COMMAND = "python -m tools.data.varieties"
#: Characteristics of the fields: the rationals and two primes.
CHARACTERISTICS = (0, 32003, 2147483647)


def singular_program(coordinates: CoordinateSystem, characteristic: int) -> str:
    """Return a Singular program that prints dimension, degree and Hilbert numerator."""
    names = ",".join(map(str, coordinates.symbols))
    # One a line: Singular cuts very long lines of its standard input.
    generators = ",\n".join(str(e).replace("**", "^") for e in equations(coordinates))
    return (
        f"ring r={characteristic},({names}),dp;\n"
        f"ideal i={generators};\n"
        "ideal g=std(i);\n"
        'print(dim(g)); print(mult(g)); print(hilb(g,2),"%s"); quit;\n'
    )


def compute(coordinates: CoordinateSystem, characteristic: int) -> dict[str, Any]:
    """Run Singular on one variety over one field."""
    program = singular_program(coordinates, characteristic)
    printed = singular.run(program)
    lines = printed.split()
    if len(lines) != 3:
        message = f"Singular on {coordinates} printed {printed!r}"
        raise SystemExit(message)
    numerator = [int(number) for number in lines[2].split(",")]
    # Singular ends the list with the degree shift of the module, 0 for an ideal.
    return {
        "dimension": int(lines[0]),
        "degree": int(lines[1]),
        "hilbert_numerator": numerator[:-1],
    }


def variety(coordinates: CoordinateSystem) -> dict[str, Any]:
    """Return the record of one variety, the same over every field."""
    results = [compute(coordinates, characteristic) for characteristic in CHARACTERISTICS]
    if any(result != results[0] for result in results):
        message = f"{coordinates}: the fields {CHARACTERISTICS} disagree: {results}"
        raise SystemExit(message)
    record = results[0]
    if sum(record["hilbert_numerator"]) != record["degree"]:
        message = f"{coordinates}: the Hilbert series does not have the degree: {record}"
        raise SystemExit(message)
    return {
        "coordinates": coordinates.name,
        "ambient_dimension": len(coordinates.symbols),
        "equations": len(equations(coordinates)),
        **record,
    }


def main() -> int:
    """Build or check the record; return the exit code."""
    arguments = parser(__doc__).parse_args()
    varieties = [variety(coordinates) for coordinates in SYSTEMS]
    manifest = {
        "command": COMMAND,
        "characteristics": list(CHARACTERISTICS),
        "versions": {"Singular": singular.version(), **versions("sympy")},
        "sha256": canonical_sha256(varieties),
    }
    text = json.dumps({"manifest": manifest, "varieties": varieties}, indent=1)
    confirmed = f"dimension and degree of {len(varieties)} varieties"
    return save({TARGET: text + "\n"}, check=arguments.check, confirmed=confirmed)


if __name__ == "__main__":
    sys.exit(main())
