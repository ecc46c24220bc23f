"""`gsp constraint`: what each of the ten kinds measures, with equations and their degrees."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from gspcli.catalogue.bounds import LAZARD, MOURRAIN, coordinates_label, varieties
from gspcli.catalogue.constraints import ConstraintFacts, Degrees, constraint_facts
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
    if o.kind is None:
        shown = [constraint_facts(each) for each in KINDS]
        tables = [_overview(shown)]
    else:
        shown = [constraint_facts(each) for each in parse_kinds(o.kind)]
        if len(shown) > 1:
            names = listed([f"{facts.kind}" for facts in shown], "and")
            say(f"{o.kind.upper()} is a distance and an angle: here are both, {names}")
        if o.output.format == "csv":
            tables = [_equation_list(shown)]
        else:
            tables = [table for facts in shown for table in _page(facts)]
    document = {
        "schema": "gsp.constraint/1",
        "constraints": [_document(facts) for facts in shown],
    }
    latex = _latex_overview(shown) if o.kind is None else "\n".join(map(_latex_page, shown))
    emit(o.output, tables, document=document, texts={"latex": latex})


def _row(facts: ConstraintFacts) -> dict[str, Any]:
    return {
        "kind": facts.kind.name,
        "equation": facts.definition.text,
        "degree_lazard": facts.paper_lazard.two_sided,
        "degree_mourrain": facts.paper_mourrain.two_sided,
        "degree_lowest": facts.lowest.two_sided,
        "degree_lowest_one_sided": facts.lowest.one_sided if facts.kind.has_sides else None,
        "coordinates": coordinates_label(facts.lowest_coordinates),
        "surface": facts.surface,
        "realization": realization(facts.kind).chain.name,
        "meaning": facts.meaning,
    }


def _overview(shown: list[ConstraintFacts]) -> Result:
    notes = (*_LEGEND, "surface: plane P, sphere S or cylinder C under a fixed orientation")
    return Result(_ALL_COLUMNS, [_row(facts) for facts in shown], notes=notes)


def _equations(facts: ConstraintFacts) -> list[dict[str, Any]]:
    """Return the equations: as stated in (R, T), Lazard's, Mourrain's, that of lowest degree."""
    papers = {LAZARD: ("Lazard", facts.paper_lazard), MOURRAIN: ("Mourrain", facts.paper_mourrain)}
    rows: list[dict[str, Any]] = [
        {
            "system": "as stated",
            "coordinates": "R,T",
            "writing": facts.definition,
            # The degree that Proposition 4.1 gives is that of the equation as stated.
            "paper": facts.paper_lazard,
            "lowest": None,
        }
    ]
    for coordinates, writing in facts.equations.items():
        name, paper = papers.get(coordinates, ("lowest degree", None))
        rows.append(
            {
                "system": name,
                "coordinates": coordinates,
                "writing": writing,
                "paper": paper,
                "lowest": facts.degrees[coordinates],
            }
        )
    return rows


def _equation_rows(facts: ConstraintFacts) -> list[dict[str, Any]]:
    return [
        {
            "kind": facts.kind.name,
            "system": row["system"],
            "coordinates": coordinates_label(row["coordinates"]),
            "equation": row["writing"].text,
            "degree_paper": row["paper"] and row["paper"].two_sided,
            "degree_lowest": row["lowest"] and row["lowest"].two_sided,
            "degree_lowest_one_sided": _one_sided(facts, row["lowest"]),
        }
        for row in _equations(facts)
    ]


def _one_sided(facts: ConstraintFacts, degrees: Degrees | None) -> int | None:
    return degrees.one_sided if degrees is not None and facts.kind.has_sides else None


def _equation_list(shown: list[ConstraintFacts]) -> Result:
    """Return the equations of several kinds in one table."""
    rows = [row for facts in shown for row in _equation_rows(facts)]
    return Result([Field(key) for key in rows[0]], rows, part="equations")


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
    one_sided = FIELDS.of("degree_lowest_one_sided")
    if not facts.kind.has_sides:
        one_sided = []
    difference = any(row["difference"] is not None for row in degrees)
    return [
        Result(
            [
                *FIELDS.of("system equation degree_paper degree_lowest@2"),
                *one_sided,
                FIELDS["coordinates"],
            ],
            _equation_rows(facts),
            title=f"{facts.kind}: {facts.meaning}",
            notes=_LEGEND,
        ),
        Result(
            [
                *FIELDS.of("coordinates@2 variety degree_lowest@3"),
                *one_sided,
                *FIELDS.of("difference" if difference else ""),
            ],
            degrees,
            notes=_remarks(facts),
        ),
    ]


def _remarks(facts: ConstraintFacts) -> list[str]:
    where = f"in {coordinates_label(facts.lowest_coordinates)}"
    if facts.kind.has_sides:
        remarks = [
            f"one-sided: degree {facts.lowest.one_sided} {where}, {facts.why_lowest}",
            f"two-sided: degree {facts.lowest.two_sided}, the square of that equation",
        ]
    else:
        remarks = [f"degree {facts.lowest.two_sided} {where}: {facts.why_lowest}"]
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


def _document(facts: ConstraintFacts) -> dict[str, Any]:
    chain = realization(facts.kind)
    return {
        "kind": facts.kind.name,
        "meaning": facts.meaning,
        "equations": [
            {
                "system": row["system"],
                "coordinates": row["coordinates"].split(","),
                "text": row["writing"].text,
                "latex": row["writing"].latex,
                "degree_paper": row["paper"] and asdict(row["paper"]),
                "degree_lowest": row["lowest"] and asdict(row["lowest"]),
            }
            for row in _equations(facts)
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
    lines = [
        r"\begin{tabular}{llrrrl}",
        r"\toprule",
        r"kind & equation & Lazard & Mourrain & lowest & surface \\",
        r"\midrule",
    ]
    for facts in shown:
        cells = [
            facts.kind.name,
            f"${facts.definition.latex}$",
            str(facts.paper_lazard.two_sided),
            str(facts.paper_mourrain.two_sided),
            str(facts.lowest.two_sided),
            facts.surface or "",
        ]
        lines.append(" & ".join(cells) + r" \\")
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _latex_page(facts: ConstraintFacts) -> str:
    lines = [f"% {facts.kind}: {facts.meaning}", r"\begin{align*}"]
    equations = [
        rf"  & {row['writing'].latex} && \text{{{row['system']}}}" for row in _equations(facts)
    ]
    return "\n".join([*lines, " \\\\\n".join(equations), r"\end{align*}", ""])
