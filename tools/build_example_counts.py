"""Count the complex solutions of the example instances by Gröbner bases and record them.

    python tools/build_example_counts.py [--check [--sample N]] [NAME ...]

The complex counts are independent of the package's solvers. The poses are the unit dual quaternions
e + f (N = e.e = 1, e.f = 0), two for each pose, and the constraints polynomials in them. Singular
(Debian: ``apt-get install singular``) gives the dimension of the solution set over a prime field,
the number of solutions with multiplicity, and of distinct ones from the minimal polynomial of a
random linear form; two primes must agree. Square roots in an instance exist modulo the chosen
primes and are kept consistent. The cosine of an angle that is no multiple of 30 degrees is replaced
by a random residue, so such a count is that of the instance's geometry with generic angles.

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

sys.path.insert(0, str(ROOT))

from gspcli.catalogue.kinds import AHH, ALL, DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.cli.progress import progress
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Point, Vector
from gspcli.solver.api import solve
from gspcli.spec import load

EXAMPLES = ROOT / "data" / "examples"
TARGET = EXAMPLES / "expected.json"
COMMAND = "python tools/build_example_counts.py"
FIRST_PRIME = 500_000_000

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


class NoRootError(Exception):
    """A square root of the instance does not exist modulo the prime."""


class Residues:
    """The numbers of an instance modulo a prime."""

    def __init__(self, prime: int) -> None:
        self.prime = prime

    def rational(self, value: Fraction) -> int:
        """Return the residue of a fraction."""
        return value.numerator * pow(value.denominator, -1, self.prime) % self.prime

    def root(self, value: Fraction) -> int:
        """Return a square root; those of products are products of those of the factors."""
        product = value.numerator * value.denominator
        root = self.rational(Fraction(1, value.denominator))
        for factor, power in sympy.factorint(product).items():
            root = root * pow(factor, power // 2, self.prime) % self.prime
            if power % 2:
                of_factor = sympy.sqrt_mod(factor, self.prime)
                if of_factor is None:
                    raise NoRootError
                root = root * of_factor % self.prime
        return root

    def number(self, number: Number) -> int:
        """Return the residue of an exact number made of fractions and their square roots."""
        if number.fraction is not None:
            return self.rational(number.fraction)
        if number.operation == "sqrt":
            return self.root(number.arguments[0].fraction)
        parts = [self.number(argument) for argument in number.arguments]
        match number.operation:
            case "+":
                result = parts[0] + parts[1]
            case "-":
                result = parts[0] - parts[1]
            case "*":
                result = parts[0] * parts[1]
            case "/":
                result = parts[0] * pow(parts[1], -1, self.prime)
            case "neg":
                result = -parts[0]
            case operation:
                message = f"no residue of {operation} is known"
                raise SystemExit(message)
        return result % self.prime

    def norm(self, direction: Vector) -> int:
        """Return the length of a direction with rational components."""
        return self.root(sum((x.fraction or Fraction(0)) ** 2 for x in direction) or Fraction(0))

    def cosine(self, angle: Number, unit: AngleUnit) -> int:
        """Return the cosine, of a generic angle if it is no multiple of 30 degrees."""
        degrees = angle.fraction
        if unit is AngleUnit.DEGREE and degrees is not None and degrees % 30 == 0:
            exact = sympy.cos(sympy.pi * int(degrees) / 180)
            sign = -1 if exact < 0 else 1
            square = sympy.Rational(exact**2)
            return sign * self.root(Fraction(int(square.p), int(square.q)))
        return random.Random(f"{angle} {self.prime}").randrange(self.prime)


def _list(name: str, values: list[int]) -> str:
    return f"{name}=list(" + ",".join(f"poly({value})" for value in values) + ");"


def _direction(geometry: Geometry) -> Vector:
    zero = Number.of(0)
    if isinstance(geometry, Point):
        return (zero, zero, zero)
    return getattr(geometry, "direction", None) or geometry.normal  # type: ignore[union-attr]


def equation(constraint: Constraint, unit: AngleUnit, field: Residues) -> str:
    """Return Singular statements that add a constraint to the ideal i."""
    kind = constraint.kind
    u, v = _direction(constraint.platform), _direction(constraint.base)
    text = " ".join(
        _list(name, [field.number(number) for number in vector])
        for name, vector in (
            ("y", constraint.platform.position),
            ("x", constraint.base.position),
            ("u", u),
            ("v", v),
        )
    )
    # As a polynomial: products of Singular's integers overflow.
    d = f"poly({field.number(constraint.value)})" if kind.is_distance else ""
    # The square of r = R y + T - x, and the products of r with v and R u, are quadrics.
    text += " Q=rho+dt(y,y)+dt(x,x)+2*dt(y,U)-2*dt(x,T)-2*dt(turn(e,y),x);"
    if kind is DPP:
        return text + f" i=i,Q-{d}^2;"
    if kind in (DPL, DPH):
        text += " F=dt(add(add(turn(e,y),T,1),x,-1),v); G=dt(v,v);"
    elif kind in (DLP, DHP):
        text += " F=dt(add(add(turn(g,x),U,-1),y,-1),u); G=dt(u,u);"
    if kind in (DPL, DLP):
        return text + f" i=i,Q*G-F^2-{d}^2*G;"
    if kind in (DPH, DHP):
        if constraint.side is Side.BOTH:
            return text + f" i=i,F^2-{d}^2*G;"
        sign = "-" if constraint.side is Side.POSITIVE else "+"
        return text + f" i=i,F{sign}{d}*({field.norm(v if kind is DPH else u)});"
    text += " G=dt(turn(e,u),v);"
    if kind is DLL:
        # r . (Ru x v) = (r x Ru) . v, and T x Ru is the vector part of 2 f u e*.
        text += (
            " F=dt(turn(e,vec(qm(pure(y),pure(u)))),v)+2*dt(vec(qm(qm(f,pure(u)),g)),v)"
            "-dt(vec(qm(pure(x),pure(turn(e,u)))),v);"
            f" i=i,F^2-{d}^2*(dt(u,u)*dt(v,v)-G^2);"
        )
        return text
    angle = constraint.value
    if kind not in (ALL, AHH):
        angle = Number.of(90 - (angle.fraction or Fraction(0)))
    cosine = field.cosine(angle, unit) * field.norm(u) * field.norm(v)
    return text + f" i=i,G{'+' if kind is AHH else '-'}({cosine % field.prime});"


def count(instance: Instance, prime: int) -> dict[str, int]:
    """Return dimension and counts of the complex solutions modulo a prime.

    Raises
    ------
    NoRootError
        If another prime is needed.
    """
    field = Residues(prime)
    unit = instance.units.angle
    equations = "\n".join(equation(c, unit, field) for c in instance.constraints)
    # The values of a generic linear form t separate the points.
    names = VARIABLES.split(",")
    chosen = random.Random(prime)
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
    """Return the record of one example: the same modulo two primes."""
    instance = load(path)
    results: dict[int, dict[str, int]] = {}
    prime = FIRST_PRIME
    while len(results) < 2:
        prime = sympy.nextprime(prime)
        try:
            results[prime] = count(instance, prime)
        except NoRootError:
            continue
    first, second = results.values()
    if first != second:
        message = f"{path.name}: the primes disagree: {results}"
        raise SystemExit(message)
    record = {
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "type": instance.type.id,
        **first,
        "primes": list(results),
        "generic_angles": _has_generic_angles(instance),
    }
    if first["dimension"] == 0:
        record |= real_poses(path.stem, instance, first["distinct"])
    return record


def real_poses(name: str, instance: Instance, distinct: int) -> dict[str, Any]:
    """Return the record of the real poses of an example with finitely many."""
    found = solve(instance).counts
    if found.found != distinct:
        message = f"{name}: the solver finds {found.found} poses, the Gröbner basis {distinct}"
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
    """Compute the counts and write or compare the record; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("names", nargs="*", help="examples (default: all)")
    arguments = options.parse_args()
    paths = sorted(EXAMPLES.glob("*.yaml"))
    wanted = [path for path in paths if path.stem in arguments.names or not arguments.names]
    wanted = sampled(wanted, arguments.sample if arguments.check else None)
    recorded = json.loads(TARGET.read_text(encoding="utf-8")) if TARGET.exists() else {}
    examples = {
        path.stem: recorded["examples"][path.stem]
        for path in paths
        if path not in wanted and path.stem in recorded.get("examples", {})
    }
    for path in progress(wanted, total=len(wanted), label="counting solutions"):
        examples[path.stem] = counts(path)
    document = {
        "manifest": {
            "command": COMMAND,
            "versions": {
                "Singular": singular.version(),
                "sympy": sympy.__version__,
                "python": platform.python_version(),
            },
        },
        "examples": dict(sorted(examples.items())),
    }
    text = json.dumps(document, indent=1, ensure_ascii=False) + "\n"
    return save(
        {TARGET: text},
        check=arguments.check,
        confirmed=f"complex and real poses of {len(wanted)} of {len(paths)} examples",
    )


if __name__ == "__main__":
    sys.exit(main())
