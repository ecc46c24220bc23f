"""Count the complex solutions of the shipped instances by Gröbner bases and record them.

    python tools/build_example_counts.py [--check [--sample N]] [NAME ...]

The complex counts are independent of the package's solvers and of its statements of the
constraints (`gspcli.geometry.polynomials`). The poses are the unit dual quaternions
e + f (N = e.e = 1, e.f = 0), two for each pose, and the constraints polynomials in them. Singular
(Debian: ``apt-get install singular``) gives the dimension of the solution set over a prime field,
the number of solutions with multiplicity, and of distinct ones from the minimal polynomial of a
random linear form; two primes must agree. Square roots, sines and cosines in an instance exist
modulo the chosen primes and are kept consistent (`residues`). Of the real platforms the same is
also counted with random values: the count of the geometry. The cosine of an angle that is no
multiple of 30 degrees is replaced by a random residue, so such a count is that of the instance's
geometry with generic angles.

The real poses are those that the package's solver finds; `certified` says how many of the distinct
solutions are proved, with whether they are real, by interval arithmetic. That the list is complete
rests on the count modulo primes, which is evidence and no proof over the rationals; a proved bound
that equals it (`gsp check`) makes it one. Where a number is known otherwise, both must agree.
"""

from __future__ import annotations

import hashlib
import json
import platform
import random
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import singular
import sympy
from recording import ROOT, parser, sampled, save
from residues import NoRootError, Residues, direction, primes

sys.path.insert(0, str(ROOT))

from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.cli.progress import progress
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.resources import INSTANCE_FOLDERS
from gspcli.solver.api import solve
from gspcli.spec import load

EXAMPLES, PLATFORMS = FOLDERS = tuple(ROOT / "data" / name for name in INSTANCE_FOLDERS)
RECORD = "expected.json"
COMMAND = "python tools/build_example_counts.py"

#: Real poses known from elsewhere: how many, and from where.
KNOWN: dict[str, tuple[int, str]] = {
    "example-6.8": (64, "the paper: Tables 1 and 2"),
    "dietmaier": (40, "P. Dietmaier 1998"),
    "no-real-pose": (0, "the triangle inequality, in the comment of the file"),
    "figure-2": (32, "4 real rotations, each with one real position for each choice of 3 signs"),
    "figure-3": (4, "2 real normals, 2 real turns, one position; in the comment of the file"),
    "fixture-3-2-1": (4, "2 real normals, 2 real turns, one position"),
}

#: Names of the variables: the quaternion e and the quaternion f.
VARIABLES = "e0,e1,e2,e3,f0,f1,f2,f3"
#: Products of quaternions and vectors as Singular procedures on lists of four or three polynomials.
PROCEDURES = """
proc qm(list a, list b) { return(list(
  a[1]*b[1]-a[2]*b[2]-a[3]*b[3]-a[4]*b[4], a[1]*b[2]+a[2]*b[1]+a[3]*b[4]-a[4]*b[3],
  a[1]*b[3]-a[2]*b[4]+a[3]*b[1]+a[4]*b[2], a[1]*b[4]+a[2]*b[3]-a[3]*b[2]+a[4]*b[1])); }
proc cj(list a) { return(list(a[1],-a[2],-a[3],-a[4])); }
proc vec(list a) { return(list(a[2],a[3],a[4])); }
proc pure(list a) { return(list(poly(0),a[1],a[2],a[3])); }
proc dt(list a, list b) { return(a[1]*b[1]+a[2]*b[2]+a[3]*b[3]); }
proc add(list a, list b, poly s) { return(list(a[1]+s*b[1],a[2]+s*b[2],a[3]+s*b[3])); }
proc turn(list e, list a) { return(vec(qm(qm(e,pure(a)),cj(e)))); }
"""
POSES = """
list e=e0,e1,e2,e3; list f=f0,f1,f2,f3; list g=cj(e); poly two=2;
list T=vec(qm(f,g)); T=list(two*T[1],two*T[2],two*T[3]);
list U=vec(qm(g,f)); U=list(two*U[1],two*U[2],two*U[3]);
poly rho=4*(f0^2+f1^2+f2^2+f3^2);
ideal i=e0^2+e1^2+e2^2+e3^2-1,e0*f0+e1*f1+e2*f2+e3*f3;
list y,x,u,v; poly Q,F,G;
"""


def _list(name: str, values: list[int]) -> str:
    return f"{name}=list(" + ",".join(f"poly({value})" for value in values) + ");"


def equation(
    constraint: Constraint, unit: AngleUnit, field: Residues, *, value: int | None = None
) -> str:
    """Return Singular statements that add a constraint to the ideal i.

    Parameters
    ----------
    constraint, unit
        The constraint and the unit of angles.
    field
        The numbers modulo a prime.
    value
        A residue that stands for the distance or the cosine; None for those of the constraint.
    """
    kind = constraint.kind
    u, v = direction(constraint.platform), direction(constraint.base)
    text = " ".join(
        _list(name, [field.number(number) for number in vector])
        for name, vector in (
            ("y", constraint.platform.position),
            ("x", constraint.base.position),
            ("u", u),
            ("v", v),
        )
    )
    # As polynomials: products of Singular's integers overflow.
    d, square = _distance(constraint, field, value) if kind.is_distance else ("", "")
    # The square of r = R y + T - x, and the products of r with v and R u, are quadrics.
    text += " Q=rho+dt(y,y)+dt(x,x)+2*dt(y,U)-2*dt(x,T)-2*dt(turn(e,y),x);"
    if kind is DPP:
        return text + f" i=i,Q-{square};"
    if kind in (DPL, DPH):
        text += " F=dt(add(add(turn(e,y),T,1),x,-1),v); G=dt(v,v);"
    elif kind in (DLP, DHP):
        text += " F=dt(add(add(turn(g,x),U,-1),y,-1),u); G=dt(u,u);"
    if kind in (DPL, DLP):
        return text + f" i=i,Q*G-F^2-{square}*G;"
    if kind in (DPH, DHP):
        if constraint.side is Side.BOTH:
            return text + f" i=i,F^2-{square}*G;"
        sign = "-" if constraint.side is Side.POSITIVE else "+"
        return text + f" i=i,F{sign}{d}*({field.norm(v if kind is DPH else u)});"
    text += " G=dt(turn(e,u),v);"
    if kind is DLL:
        # r . (Ru x v) = (r x Ru) . v, and T x Ru is the vector part of 2 f u e*.
        text += (
            " F=dt(turn(e,vec(qm(pure(y),pure(u)))),v)+2*dt(vec(qm(qm(f,pure(u)),g)),v)"
            "-dt(vec(qm(pure(x),pure(turn(e,u)))),v);"
            f" i=i,F^2-{square}*(dt(u,u)*dt(v,v)-G^2);"
        )
        return text
    if kind not in (ALL, ALH, AHL, AHH):
        raise ValueError(kind)
    angle = constraint.value
    if kind in (ALH, AHL):
        angle = Number.of(90 - (angle.fraction or Fraction(0)))
    cosine = field.cosine(angle, unit) if value is None else value
    cosine *= field.norm(u) * field.norm(v)
    return text + f" i=i,G{'+' if kind is AHH else '-'}({cosine % field.prime});"


def _distance(constraint: Constraint, field: Residues, value: int | None) -> tuple[str, str]:
    """Return a distance, needed where a side is stated, and its square."""
    if value is not None:
        return f"poly({value})", f"poly({value * value % field.prime})"
    sided = constraint.kind.has_sides and constraint.side is not Side.BOTH
    d = f"poly({field.number(constraint.value)})" if sided else ""
    return d, f"poly({field.square(constraint.value)})"


def count(instance: Instance, prime: int, *, generic: bool = False) -> dict[str, int]:
    """Return dimension and counts of the complex solutions modulo a prime.

    With `generic` the values of the constraints are random: the count of the geometry.

    Raises
    ------
    NoRootError
        If another prime is needed.
    """
    field = Residues(prime)
    unit = instance.units.angle
    names = VARIABLES.split(",")
    chosen = random.Random(prime)
    values = [chosen.randrange(1, prime) if generic else None for _ in instance.constraints]
    pairs = zip(instance.constraints, values, strict=True)
    equations = "\n".join(equation(c, unit, field, value=value) for c, value in pairs)
    # The values of a generic linear form t separate the points.
    form = "+".join(f"{chosen.randrange(prime)}*{name}" for name in names)
    program = (
        f"option(redSB);\nring r={prime},({VARIABLES},t),dp;\n{PROCEDURES}{POSES}{equations}\n"
        f"ideal s=std(i+ideal(t-({form}))); print(dim(s));\n"
        "if (dim(s)==0) { print(vdim(s)); poly m=finduni(s)[9];"
        " print(deg(m)-deg(gcd(m,diff(m,t)))); } quit;\n"
    )
    printed = singular.run(program)
    words = [word for word in printed.split("\n") if word.strip().lstrip("-").isdigit()]
    numbers = [int(word) for word in words]
    if len(numbers) not in (1, 3):
        message = f"Singular printed {printed!r}"
        raise SystemExit(message)
    if len(numbers) == 1:
        return {"dimension": numbers[0]}
    # A pose is two unit quaternions.
    return {"dimension": 0, "complex": numbers[1] // 2, "distinct": numbers[2] // 2}


def counts(path: Path) -> dict[str, Any]:
    """Return the record of one file: the same modulo two primes."""
    instance = load(path)
    results: dict[int, dict[str, int]] = {}
    geometry: dict[int, dict[str, int]] = {}
    for prime in primes(instance):
        try:
            results[prime] = count(instance, prime)
        except NoRootError:
            continue
        if path.parent == PLATFORMS:
            geometry[prime] = count(instance, prime, generic=True)
        if len(results) == 2:
            break
    first = _agreeing(path, results)
    record = {
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "type": instance.type.id,
        **first,
        "primes": list(results),
        "generic_angles": _has_generic_angles(instance),
    }
    if geometry:
        record["geometry"] = _agreeing(path, geometry)
    if first["dimension"] == 0:
        record |= real_poses(path, instance, first)
    return record


def _agreeing(path: Path, results: dict[int, dict[str, int]]) -> dict[str, int]:
    first, second = results.values()
    if first != second:
        message = f"{path.name}: the primes disagree: {results}"
        raise SystemExit(message)
    return first


def real_poses(path: Path, instance: Instance, exact: dict[str, int]) -> dict[str, Any]:
    """Return the record of the real poses of an instance with finitely many.

    Of a platform for which the solver finds another number of poses nothing is recorded: its
    real poses are then not known. Of an example that is a failure.
    """
    name = path.stem
    found = solve(instance).counts
    if found.found != exact["distinct"]:
        if path.parent == PLATFORMS:
            return {}
        message = f"{name}: {found.found} poses found, {exact['distinct']} by the Gröbner basis"
        raise SystemExit(message)
    record = {"real": found.real, "certified": found.certified}
    if name in KNOWN:
        real, source = KNOWN[name]
        if real != found.real:
            message = f"{name}: the solver finds {found.real} real poses, but {real} by {source}"
            raise SystemExit(message)
        record["real_known_from"] = source
    return record


def _has_generic_angles(instance: Instance) -> bool:
    return any(
        not c.kind.is_distance and (c.value.fraction is None or c.value.fraction % 30 != 0)
        for c in instance.constraints
    )


def main() -> int:
    """Compute the counts and write or compare the records; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("names", nargs="*", help="instance files (default: all)")
    arguments = options.parse_args()
    files = {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.yaml"))}
    wanted = [name for name in files if name in arguments.names or not arguments.names]
    wanted = sampled(wanted, arguments.sample if arguments.check else None)
    records = {folder: _recorded(folder) for folder in FOLDERS}
    for folder, entries in records.items():
        for name in [name for name in entries if files.get(name, folder).parent != folder]:
            del entries[name]
    for name in progress(wanted, total=len(wanted), label="counting solutions"):
        records[files[name].parent][name] = counts(files[name])
    versions = {
        "Singular": singular.version(),
        "sympy": sympy.__version__,
        "python": platform.python_version(),
    }
    documents = {
        folder / RECORD: {
            "manifest": {"command": COMMAND, "versions": versions},
            "examples": dict(sorted(entries.items())),
        }
        for folder, entries in records.items()
    }
    return save(
        {
            path: json.dumps(document, indent=1, ensure_ascii=False) + "\n"
            for path, document in documents.items()
        },
        check=arguments.check,
        confirmed=f"complex and real poses of {len(wanted)} of {len(files)} instance files",
    )


def _recorded(folder: Path) -> dict[str, Any]:
    path = folder / RECORD
    if not path.exists():
        return {}
    recorded: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))["examples"]
    return recorded


if __name__ == "__main__":
    sys.exit(main())
