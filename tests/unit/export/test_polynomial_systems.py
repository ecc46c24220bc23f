"""Exported equations vanish at the poses of the solver, in all coordinates, and nowhere near."""

import numpy as np
import pytest

from gspcli.export.answers import read_answer
from gspcli.export.formats import FORMATS, SystemFormat
from gspcli.export.polynomial_systems import MOTIONS, system
from gspcli.geometry.quaternions import study_from_pose
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

NAMES = ["dietmaier", "example-6.8", "figure-2", "nano-hexapod", "surfaces-pcc", "parallel-lines"]

SYSTEMS = {name: form for name, form in FORMATS.items() if isinstance(form, SystemFormat)}


def points(coordinates, names, result):
    """Return the unknowns at the poses, those that the coordinates have."""
    if coordinates == "rt":
        columns = np.concatenate([result.R.reshape(-1, 9), result.T], axis=1).T
        return dict(zip(names, columns, strict=True))
    e, f = study_from_pose(result.R, result.T)
    if coordinates == "study":
        return dict(zip(names, np.concatenate([e, f], axis=1).T, strict=True))
    whole = np.abs(e[:, 0]) > 1e-3
    e, f = (part[whole] / e[whole, :1] for part in (e, f))
    inverse = 1 / (e * e).sum(axis=1, keepdims=True)
    return dict(zip(names, np.concatenate([e[:, 1:], f, inverse], axis=1).T, strict=True))


def worst(polynomials, known):
    """Return the largest value of the polynomials, relative to that of their terms."""
    found = 0.0
    for polynomial in polynomials:
        value, size = 0.0, 0.0
        for monomial, coefficient in polynomial.terms.items():
            term = float(coefficient) * np.prod([known[name] for name in monomial], axis=0)
            value, size = value + term, size + np.abs(term)
        scale = max(abs(float(number)) for number in polynomial.terms.values())
        found = max(found, float((np.abs(value) / (size + scale)).max()))
    return found


@pytest.mark.parametrize("coordinates", MOTIONS)
@pytest.mark.parametrize("name", NAMES)
def test_poses_satisfy_the_equations(name, coordinates):
    instance = load(instance_files()[name])
    exported = system(instance, MOTIONS[coordinates]()).rounded(40)
    assert not exported.constants
    assert len(exported.polynomials) == len(exported.names)
    known = points(coordinates, exported.names, solve(instance))
    assert worst(exported.polynomials, known) < 1e-13
    moved = {key: column + 1e-3 for key, column in known.items()}
    assert worst(exported.polynomials, moved) > 1e-5


def test_rational_platforms_have_no_constants():
    assert not system(load(instance_files()["dietmaier"]), MOTIONS["rt"]()).constants


def test_the_files_are_what_the_programs_read():
    small = system(load(instance_files()["six-planes"]), MOTIONS["rt"]())
    texts = {name: program.write(small, 20) for name, program in SYSTEMS.items()}
    beginnings = {
        "msolve": "r11,r12,r13,r21,r22,r23,r31,r32,r33,t1,t2,t3\n0\n",
        "phcpack": "12\n",
        "macaulay2": "R = QQ[r11, r12",
        "singular": "ring r = 0,(r11,r12",
        "hcjl": "@var r11 r12",
        "sympy": "unknowns = r11, r12",
    }
    assert set(beginnings) == set(texts)
    for name, beginning in beginnings.items():
        assert beginning in texts[name]
    assert texts["phcpack"].count(";\n") == 12
    compile(texts["sympy"], "system", "exec")


def test_irrational_constants_become_what_the_table_says():
    curved = system(load(instance_files()["surfaces-pps"]), MOTIONS["rt"]())
    assert curved.constants
    for name, program in SYSTEMS.items():
        same = program.write(curved, 20) == program.write(curved, 30)
        assert same == (program.irrational != "decimals"), name


PHC = """\
THE SOLUTIONS :
1 8
===========================================================================
solution 1 :    start residual :  1.0E-16   #iterations : 1   success
t :  0.00000000000000E+00   0.00000000000000E+00
m : 1
the solution for t :
 q0 :  1.00000000000000E+00   0.0
 q1 :  0.0   0.0
 q2 :  0.0   0.0
 q3 :  0.0   0.0
 f0 :  0.0   0.0
 f1 :  1.00000000000000E+00   5.00000000000000E-01
 f2 :  0.0   0.0
 f3 :  0.0   0.0
== err :  1.0E-15 = rco :  3.5E-02 = res :  6.5E-15 = complex regular ==
"""


def test_phcpack_is_read():
    found = read_answer(PHC, "x")
    assert found is not None
    assert np.allclose(found.T, [[2 + 1j, 0, 0]])
    assert np.allclose(found.R, np.eye(3))


def test_opposite_points_are_one_pose():
    heading = ",".join(f"{letter}{k}" for letter in "qf" for k in range(4))
    text = f"# dimension 0, degree 4\n{heading}\n1,0,0,0,0,1,0,0\n-1,0,0,0,0,-1,0,0\n"
    found = read_answer(text + "0,1,0,0,0,0,0,1\n", "x")
    assert found is not None
    assert len(found.R) == 2
    again = read_answer(text + "1,0,0,0,0,1,0,0\n", "x")
    assert again is not None
    # A point that is listed twice stays listed twice.
    assert len(again.R) == 2


def test_boxes_of_msolve_are_told_apart_by_what_they_satisfy():
    def box(numbers):
        return "[" + ", ".join(f"[{n} / 2^1, {n} / 2^1]" for n in numbers) + "]"

    study = read_answer(f"[0, [1,\n[{box([2, 0, 0, 0, 0, 2, 0, 0])}]\n]]:\n", "x")
    affine = read_answer(f"[0, [1,\n[{box([0, 0, 0, 0, 2, 0, 0, 2])}]\n]]:\n", "x")
    assert study is not None
    assert affine is not None
    assert np.allclose(study.T, affine.T)
    assert study.claimed_real == (True,)
    none = read_answer("[0, [1,\n[]\n]]:\n", "x")
    assert none is not None
    assert len(none.R) == 0


@pytest.mark.parametrize("text", ['[{"R": []}]', "qw,qx,qy,qz,tx,ty,tz\n1,0,0,0,0,0,0\n", ""])
def test_other_files_are_left_to_others(text):
    assert read_answer(text, "x") is None
