"""`gsp constraint`: the exact overview, a page, LaTeX, JSON, and mistakes."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

Gsp = Callable[..., Any]

OVERVIEW = """\
kind,equation,degree_lazard,degree_mourrain,degree_lowest,degree_lowest_one_sided,\
coordinates,surface,realization,meaning
DPP,|RY + T − X|² = d²,2,1,1,,"(R, T, U, ρ)",S,S-P*-S,\
distance of a point of the platform from a point of the base
DPL,|(RY + T − A)×u|² = d²,2,2,2,,"(R, T)",C,S-P*-C,\
distance of a point of the platform from a line of the base
DLP,|(RB + T − X)×Rv|² = d²,4,4,2,,"(R, U)",C,C-P*-S,\
distance of a line of the platform from a point of the base
DPH,u·(RY + T − A) = ±d,2,2,2,1,"(R, T)",P,S-P*-E,\
distance of a point of the platform from a plane of the base
DHP,Rv·(X − RB − T) = ±d,4,4,2,1,"(R, U)",P,E-P*-S,\
distance of a plane of the platform from a point of the base
DLL,((RB + T − A)·(Rv×u))² = d² |Rv×u|²,4,4,2,,"(R, T×R)",P,C-R-P*-C,\
distance of a line of the platform from a line of the base
ALL,Rv·u = cos α,1,1,1,,(R),,C-P-R*-C,\
angle between a line of the platform and a line of the base
ALH,Rv·u = sin α,1,1,1,,(R),,C-R*-E,\
angle between a line of the platform and a plane of the base
AHL,Rv·u = sin α,1,1,1,,(R),,E-R*-C,\
angle between a plane of the platform and a line of the base
AHH,Rv·u = −cos α,1,1,1,,(R),,E-R*-E,\
angle between a plane of the platform and a plane of the base
"""

DHP_CSV = """\
kind,system,coordinates,equation,degree_paper,degree_lowest,degree_lowest_one_sided
DHP,as stated,"(R, T)",Rv·(X − RB − T) = ±d,4,,
DHP,Lazard,"(R, T, U)",−v·U + X·Rv − B·v = ±d,4,2,1
DHP,Mourrain,"(R, T, U, ρ, T×R)",−v·U + X·Rv − B·v = ±d,4,2,1
DHP,lowest degree,"(R, U)",−v·U + X·Rv − B·v = ±d,,2,1
"""

DLP_LATEX = r"""% DLP: distance of a line of the platform from a point of the base
\begin{align*}
  & |(R B + T - X) \times R v|^2 = d^2 && \text{as stated} \\
  & T \cdot T + 2 B \cdot U - 2 X \cdot T - 2 X \cdot R B + B \cdot B + X \cdot X - (v \cdot U - X \cdot R v + B \cdot v)^2 = d^2 && \text{Lazard} \\
  & \rho + 2 B \cdot U - 2 X \cdot T - 2 X \cdot R B + B \cdot B + X \cdot X - (v \cdot U - X \cdot R v + B \cdot v)^2 = d^2 && \text{Mourrain} \\
  & U \cdot U + 2 B \cdot U - 2 X \cdot R U - 2 X \cdot R B + B \cdot B + X \cdot X - (v \cdot U - X \cdot R v + B \cdot v)^2 = d^2 && \text{lowest degree}
\end{align*}
"""  # noqa: E501


def test_overview(gsp: Gsp) -> None:
    result = gsp("constraint", "--format", "csv")
    assert (result.code, result.out, result.err) == (0, OVERVIEW, "")


def test_overview_for_people(gsp: Gsp) -> None:
    result = gsp("constraint")
    assert result.code == 0
    lines = result.out.splitlines()
    assert any("DLP" in line and "|(RB + T − X)×Rv|² = d²" in line for line in lines)
    assert "x_base = R x_platform + T; U = RᵀT, ρ = T·T" in result.out


def test_equations_of_one_kind(gsp: Gsp) -> None:
    for name in ("DHP", "hp", "dhp"):
        result = gsp("constraint", name, "--format", "csv")
        assert (result.code, result.out) == (0, DHP_CSV)


def test_page_of_one_kind(gsp: Gsp) -> None:
    result = gsp("constraint", "DHP")
    assert result.code == 0
    for line in (
        "DHP: distance of a plane of the platform from a point of the base",
        "one-sided: degree 1 in (R, U), the signed height of the point is one inner product, "
        "w·Rv, w = RB + T − X",
        "Proposition 4.1 says 4, the degree of the equation as stated, before RᵀR = I, "
        "U = RᵀT and the like are used",
        "locus for a fixed orientation: two planes with normal Rv at distance d from X (P)",
        "realization: E-P*-S, a spherical and a planar joint, a driven slide",
    ):
        assert line in result.out.splitlines()


def test_a_name_of_two_kinds_shows_both(gsp: Gsp) -> None:
    result = gsp("constraint", "LL")
    assert "DLL: distance of a line" in result.out
    assert "ALL: angle between a line" in result.out
    assert "parallel lines: cylinder of radius d about the line through A along u (C)" in result.out


def test_latex(gsp: Gsp) -> None:
    assert gsp("constraint", "DLP", "--format", "latex").out == DLP_LATEX
    overview = gsp("constraint", "--format", "latex").out
    assert r"AHH & $R v \cdot u = -\cos \alpha$ & 1 & 1 & 1 &  \\" in overview
    assert overview.startswith(r"\begin{tabular}")


def test_json(gsp: Gsp) -> None:
    document = json.loads(gsp("constraint", "DPH", "--format", "json").out)
    assert document["schema"] == "gsp.constraint/1"
    (facts,) = document["constraints"]
    assert facts["kind"] == "DPH"
    assert facts["degree_lowest"] == 2
    assert facts["degree_lowest_one_sided"] == 1
    assert facts["lowest_coordinates"] == ["R", "T"]
    assert facts["loci"]["generic"]["surface"] == facts["surface"] == "P"
    assert facts["degrees"]["R,U"] == {"two_sided": 4, "one_sided": 2, "difference": None}
    assert [equation["system"] for equation in facts["equations"]] == [
        "as stated",
        "Lazard",
        "Mourrain",
        "lowest degree",
    ]
    assert len(json.loads(gsp("constraint", "--format", "json").out)["constraints"]) == 10


def test_output_file(gsp: Gsp, tmp_path: Path) -> None:
    target = tmp_path / "kinds.csv"
    result = gsp("constraint", "-o", str(target))
    assert (result.code, result.out) == (0, "")
    assert target.read_text(encoding="utf-8") == OVERVIEW


def test_unknown_kind(gsp: Gsp) -> None:
    result = gsp("constraint", "DHH")
    assert result.code == 2
    assert result.out == ""
    assert "unknown constraint 'DHH'" in result.err


def test_help_has_examples(gsp: Gsp) -> None:
    result = gsp("constraint", "--help")
    assert "gsp constraint DLP" in result.out


def test_the_command_needs_no_sympy() -> None:
    program = (
        "import sys; from gspcli.cli.main import run; run(['constraint', 'PL']); "
        "sys.exit(any(name in sys.modules for name in ('sympy', 'numpy', 'pandas')))"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, check=False)
    assert run.returncode == 0
