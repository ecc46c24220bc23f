"""Compute dimension and degree of the rigid-motion varieties and record them in the data.

    python tools/build_varieties.py [--check]

The degree is that of the projective closure. A Gröbner basis for an ordering by total degree needs
no homogenization: its leading monomials are those of the homogenized, saturated ideal. Done with
Singular (Debian: ``apt-get install singular``) over the rationals and modulo two primes, which must
agree. With ``--check`` the record is compared instead of written.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import platform
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import sympy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from gspcli.symbolic.coordinates import SYSTEMS, CoordinateSystem
from gspcli.symbolic.varieties import equations

TARGET = Path(__file__).resolve().parents[1] / "data" / "varieties.json"
COMMAND = "python tools/build_varieties.py"
#: Characteristics of the fields: the rationals and two primes.
CHARACTERISTICS = (0, 32003, 2147483647)
TIME_LIMIT_S = 600


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
    run = subprocess.run(
        ["Singular", "-q", "--no-rc"],
        input=program,
        capture_output=True,
        text=True,
        timeout=TIME_LIMIT_S,
        check=True,
    )
    lines = run.stdout.split()
    if len(lines) != 3:
        message = f"Singular on {coordinates} printed {run.stdout!r}"
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


def digest(content: object) -> str:
    """Return the sha256 of a JSON value in its canonical form."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def main() -> int:
    """Build or check the record; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with the record")
    arguments = parser.parse_args()
    if shutil.which("Singular") is None:
        print(
            "Singular is not installed (Debian: apt-get install singular).\n"
            f"Nothing was computed; the recorded result {TARGET.name} stays in use.",
            file=sys.stderr,
        )
        return 1
    varieties = [variety(coordinates) for coordinates in SYSTEMS]
    if arguments.check:
        recorded = json.loads(TARGET.read_text(encoding="utf-8"))["varieties"]
        if recorded != varieties:
            print(f"{TARGET.name} differs from the computation", file=sys.stderr)
            return 1
        print(f"{TARGET.name}: {len(varieties)} varieties confirmed")
        return 0
    version = subprocess.run(
        ["Singular", "--version"], capture_output=True, text=True, check=True
    ).stdout.split("\n", 1)[0]
    manifest = {
        "command": COMMAND,
        "characteristics": list(CHARACTERISTICS),
        "versions": {
            "Singular": version.split("version ")[1].split()[0],
            "sympy": sympy.__version__,
            "python": platform.python_version(),
        },
        "sha256": digest(varieties),
    }
    text = json.dumps({"manifest": manifest, "varieties": varieties}, indent=1)
    TARGET.write_text(text + "\n", encoding="utf-8")
    for record in varieties:
        print(f"{record['coordinates']:16} dim {record['dimension']} degree {record['degree']}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
