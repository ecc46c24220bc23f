"""Counting the complex poses of an instance by Singular, as unit dual quaternions.

A pose is e + f with N = e.e = 1 and e.f = 0, or its negative, and the constraints are polynomials
in these. Singular (Debian: ``apt-get install singular``) gives the dimension of the solution set
over a prime field, the number of solutions with multiplicity, and of distinct ones from the minimal
polynomial of a random linear form.
"""

from __future__ import annotations

import random

from gspcli.catalogue.kinds import AHH, DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.geometry.instance import Constraint, Instance, Side
from tools.oracle import singular
from tools.oracle.homomorphisms import Homomorphism
from tools.oracle.number_parts import direction

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


def equation(constraint: Constraint, field: Homomorphism, *, value: int | None = None) -> str:
    """Return Singular statements that add a constraint to the ideal i.

    Parameters
    ----------
    constraint
        The constraint.
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
        if value is None and constraint.value.fraction == 0:
            return text + " i=i,F;"
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
        )
        if value is None and constraint.value.fraction == 0:
            # The square of this is zero, too, but counts each pose twice.
            return text + " i=i,F;"
        return text + f" i=i,F^2-{square}*(dt(u,u)*dt(v,v)-G^2);"
    cosine = field.cosine(constraint) if value is None else value
    cosine *= field.norm(u) * field.norm(v)
    return text + f" i=i,G{'+' if kind is AHH else '-'}({cosine % field.prime});"


def _distance(constraint: Constraint, field: Homomorphism, value: int | None) -> tuple[str, str]:
    """Return a distance, needed where a side is stated, and its square."""
    if value is not None:
        return f"poly({value})", f"poly({value * value % field.prime})"
    sided = constraint.kind.has_sides and constraint.side is not Side.BOTH
    d = f"poly({field.number(constraint.value)})" if sided else ""
    return d, f"poly({field.square(constraint.value)})"


def count(instance: Instance, field: Homomorphism, *, generic: bool = False) -> dict[str, int]:
    """Return dimension and counts of the complex solutions modulo a prime.

    With `generic` the values of the constraints are random: the count of the geometry.
    """
    prime = field.prime
    names = VARIABLES.split(",")
    chosen = random.Random(prime)
    values = [chosen.randrange(1, prime) if generic else None for _ in instance.constraints]
    pairs = zip(instance.constraints, values, strict=True)
    equations = "\n".join(equation(c, field, value=value) for c, value in pairs)
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
