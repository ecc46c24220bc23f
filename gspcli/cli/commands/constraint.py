"""`gsp constraint`: what each of the ten kinds measures, with equations and their degrees."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from gspcli.catalogue.bounds import LAZARD, MOURRAIN, coordinates_label, varieties
from gspcli.catalogue.constraints import ConstraintFacts, Degrees, Writing, constraint_facts
from gspcli.catalogue.kinds import KINDS
from gspcli.catalogue.names import parse_kinds
from gspcli.catalogue.realization import realization
from gspcli.cli.options import Command, Options, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.streams import say
from gspcli.wording import listed

FIELDS = Fields("constraint")

_LEGEND = (
    "platform: point Y, line (B, v), plane (B, normal v); "
    "base: point X, line (A, u), plane (A, normal u); v and u of length 1",
    "x_base = R x_platform + T; U = RᵀT, ρ = T·T, T×R has the columns T × R_k",
    "the paper's equations of motions: Lazard (1) RᵀR = RRᵀ = I, det R = 1, U = RᵀT; Mourrain (2) "
    "det R = 1, columns and rows of R orthogonal and of length 1, (3) U = RᵀT, ρ = [T, T], "
    "(4) (i,j|k,4) = r_ik t_j − r_jk t_i: the entries of T×R up to sign",
)
_PROOF = (
    "these degrees are the lowest: at exact motions that satisfy a random constraint of the kind "
    "the monomials of lower degree have the same rank as on all motions"
)
_ALL_COLUMNS = FIELDS.of(
    "kind equation degree_lazard degree_mourrain degree_lowest degree_lowest_one_sided "
    "coordinates surface realization meaning"
)


@click.command(cls=Command)
@click.argument("kind", required=False)
@output_options()
def command(o: Options) -> None:
    """Show the ten kinds of constraint, or all that is known of one.

    The degrees under Lazard and Mourrain are those of Proposition 4.1, read off the equations as
    the paper writes them; the lowest ones are derived and proved to be the lowest. One-sided: with
    the side of the plane chosen. LL shows both the distance and the angle.

    \b
    Examples:
      gsp constraint
      gsp constraint DLP
      gsp constraint PH --format json
      gsp constraint --format latex -o constraints.tex
    """
    kinds = KINDS if o.kind is None else parse_kinds(o.kind)
    shown = [constraint_facts(kind) for kind in kinds]
    entries = [_entry(facts) for facts in shown]
    if o.kind is not None and len(shown) > 1:
        names = listed([f"{facts.kind}" for facts in shown], "and")
        say(f"{o.kind.upper()} is a distance and an angle: here are both, {names}")
    if o.kind is None:
        notes = (*_LEGEND, "surface: plane P, sphere S or cylinder C under a fixed orientation")
        tables = [Result(_ALL_COLUMNS, [*map(_row, shown, entries)], notes=notes)]
    elif o.output.format == "csv":
        rows = [row for facts in shown for row in _equation_rows(facts)]
        tables = [Result([Field(key) for key in rows[0]], rows, part="equations")]
    else:
        tables = [table for facts in shown for table in _page(facts)]
    latex = _latex_overview(shown) if o.kind is None else "\n".join(map(_latex_page, shown))
    document = {"schema": "gsp.constraint/1", "constraints": entries}
    emit(o.output, tables, document=document, texts={"latex": latex})


def _row(facts: ConstraintFacts, entry: dict[str, Any]) -> dict[str, Any]:
    more = {
        "equation": facts.definition.text,
        "degree_lowest_one_sided": _one_sided(facts, facts.lowest),
        "coordinates": coordinates_label(facts.lowest_coordinates),
        "realization": realization(facts.kind).chain.name,
    }
    return entry | more


#: An equation: by whom, in which coordinates, as the paper has it and of lowest degree.
_Equation = tuple[str, str, Writing, Degrees | None, Degrees | None]


def _equations(facts: ConstraintFacts) -> list[_Equation]:
    """Return the equations: as stated in (R, T), Lazard's, Mourrain's, that of lowest degree."""
    papers = {LAZARD: ("Lazard", facts.paper_lazard), MOURRAIN: ("Mourrain", facts.paper_mourrain)}
    # The degree that Proposition 4.1 gives is that of the equation as stated.
    rows: list[_Equation] = [("as stated", "R,T", facts.definition, facts.paper_lazard, None)]
    for coordinates, writing in facts.equations.items():
        name, paper = papers.get(coordinates, ("lowest degree", None))
        rows.append((name, coordinates, writing, paper, facts.degrees[coordinates]))
    return rows


def _equation_rows(facts: ConstraintFacts) -> list[dict[str, Any]]:
    return [
        {
            "kind": facts.kind.name,
            "system": system,
            "coordinates": coordinates_label(coordinates),
            "equation": writing.text,
            "degree_paper": paper and paper.two_sided,
            "degree_lowest": lowest and lowest.two_sided,
            "degree_lowest_one_sided": _one_sided(facts, lowest),
        }
        for system, coordinates, writing, paper, lowest in _equations(facts)
    ]


def _one_sided(facts: ConstraintFacts, degrees: Degrees | None) -> int | None:
    return degrees.one_sided if degrees is not None and facts.kind.has_sides else None


def _page(facts: ConstraintFacts) -> list[Result]:
    degrees = [
        {
            "coordinates": coordinates_label(name),
            "variety": varieties()[name].degree,
            "degree_lowest": row.two_sided,
            "degree_lowest_one_sided": _one_sided(facts, row),
            "difference": row.difference,
        }
        for name, row in facts.degrees.items()
    ]
    one_sided = " degree_lowest_one_sided" * facts.kind.has_sides
    difference = " difference" * any(row["difference"] is not None for row in degrees)
    title = f"{facts.kind}: {facts.meaning}"
    written = FIELDS.of(f"system equation degree_paper degree_lowest@2{one_sided} coordinates")
    columns = FIELDS.of(f"coordinates@2 variety degree_lowest@3{one_sided}{difference}")
    return [
        Result(written, _equation_rows(facts), title, _LEGEND),
        Result(columns, degrees, notes=_remarks(facts)),
    ]


def _remarks(facts: ConstraintFacts) -> list[str]:
    where = f"in {coordinates_label(facts.lowest_coordinates)}"
    remarks = [f"degree {facts.lowest.two_sided} {where}: {facts.why_lowest}"]
    if facts.kind.has_sides:
        remarks = [
            f"one-sided: degree {facts.lowest.one_sided} {where}, {facts.why_lowest}",
            f"two-sided: degree {facts.lowest.two_sided}, the square of that equation",
        ]
    remarks.append(_PROOF)
    paper = facts.paper_mourrain.two_sided
    if paper > facts.lowest.two_sided:
        remarks.append(
            f"Proposition 4.1 says {paper}, the degree of the equation as stated, before "
            "RᵀR = I, U = RᵀT and the like are used"
        )
    remarks += [
        f"locus for a fixed orientation{', parallel lines' * (case == 'parallel')}: "
        f"{locus.text} ({locus.surface})"
        for case, locus in facts.loci.items()
    ]
    chain = realization(facts.kind)
    remarks.append(f"realization: {chain.chain.name}, {chain.description}")
    return remarks


def _entry(facts: ConstraintFacts) -> dict[str, Any]:
    chain = realization(facts.kind)
    return {
        "kind": facts.kind.name,
        "meaning": facts.meaning,
        "equations": [
            {
                "system": system,
                "coordinates": coordinates.split(","),
                "text": writing.text,
                "latex": writing.latex,
                "degree_paper": paper and asdict(paper),
                "degree_lowest": lowest and asdict(lowest),
            }
            for system, coordinates, writing, paper, lowest in _equations(facts)
        ],
        "degree_lazard": facts.paper_lazard.two_sided,
        "degree_mourrain": facts.paper_mourrain.two_sided,
        "degree_lowest": facts.lowest.two_sided,
        "degree_lowest_one_sided": facts.lowest.one_sided,
        "lowest_coordinates": facts.lowest_coordinates.split(","),
        "why_lowest": facts.why_lowest,
        "degrees": {name: asdict(row) for name, row in facts.degrees.items()},
        "surface": facts.surface,
        "loci": {case: asdict(locus) for case, locus in facts.loci.items()},
        "realization": {"chain": chain.chain.name, "description": chain.description},
    }


def _latex_overview(shown: list[ConstraintFacts]) -> str:
    head = r"""\begin{tabular}{llrrrl}
\toprule
kind & equation & Lazard & Mourrain & lowest & surface \\
\midrule
"""
    lines = [
        f"{facts.kind.name} & ${facts.definition.latex}$ & {facts.paper_lazard.two_sided} & "
        f"{facts.paper_mourrain.two_sided} & {facts.lowest.two_sided} & {facts.surface or ''}"
        " \\\\\n"
        for facts in shown
    ]
    return "".join([head, *lines, "\\bottomrule\n\\end{tabular}\n"])


def _latex_page(facts: ConstraintFacts) -> str:
    equations = [rf"  & {one[2].latex} && \text{{{one[0]}}}" for one in _equations(facts)]
    body = " \\\\\n".join(equations)
    head = f"% {facts.kind}: {facts.meaning}\n\\begin{{align*}}\n"
    return f"{head}{body}\n\\end{{align*}}\n"
