"""`gsp enumerate`: the catalogue of types."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import Any

import click

from gspcli.catalogue import listing
from gspcli.catalogue.bounds import ONE_ORIENTATION, type_bounds
from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.names import parse_class, parse_kind_set, parse_type
from gspcli.catalogue.types import CLASSES, GspType, PlatformClass
from gspcli.cli.options import Command, Options, Whole, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Field, Fields, Result

FIELDS = Fields("enumerate")

#: Options that take several words, as in `--only PL PH A`.
_WORD_LISTS = ("--only", "--with", "--without", "--columns", "--sort")
_ESSENTIAL = ("number", "id")
#: The order in which a narrow terminal omits columns, the largest first: kinds and class, which are
#: in the id, then sharper bounds, then counts, at last the paper's own bounds.
_MINOR = {
    "theorem_5_2": 0,
    "theorem_5_3": 0,
    "theorem_5_4": 0,
    "table_3": 0,
    "generic_two_sided": 1,
    "generic_one_sided": 2,
    "best_real": 3,
    "refined_two_sided": 4,
    "refined_one_sided": 5,
    "class": 6,
}
_MOST_MINOR = 7


class _WordListCommand(Command):
    """Lets the options in `_WORD_LISTS` take words up to the next option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        joined: list[str] = []
        collecting = False
        for word in args:
            is_option = word.startswith("--") or word in ("-o", "-h")
            if collecting and not is_option:
                joined[-1] += ("," if joined[-1] else "") + word
                continue
            joined.append(word)
            collecting = word in _WORD_LISTS
            if collecting:
                joined.append("")
        return super().parse_args(ctx, joined)


def _ceilings(function: Callable[..., Any]) -> Callable[..., Any]:
    for column in reversed([c for c in listing.COLUMNS if c.numeric]):
        function = click.option(
            f"--max-{column.key.replace('_', '-')}",
            f"max_{column.key}",
            type=Whole(0),
            metavar="N",
            help=f"Keep types whose {column.key} is at most N.",
        )(function)
    return function


@click.command(cls=_WordListCommand)
@click.option(
    "--class",
    "classes",
    multiple=True,
    metavar="CLASS",
    help=f"Keep a class: {', '.join(c.id for c in CLASSES)}. Repeatable.",
)
@click.option("--only", metavar="KINDS", help="Keep types made of these kinds alone.")
@click.option("--with", "having", metavar="KINDS", help="Keep types that have each of these.")
@click.option("--without", metavar="KINDS", help="Drop types that have any of these.")
@_ceilings
@click.option("--sort", metavar="COLUMNS", help="Sort by columns; -COLUMN is descending.")
@click.option("--columns", metavar="COLUMNS", help="Show these columns, in this order.")
@click.option("--first", type=Whole(0), metavar="N", help="Show the first N rows.")
@click.option("--by-class", is_flag=True, help="Count by class, beside Proposition 2.2.")
@click.option(
    "--coincident",
    metavar="TYPE",
    is_flag=False,
    flag_value="",
    help="Count the ways to share primitives among constraints, by class; of one TYPE, list them.",
)
@output_options()
def command(o: Options) -> None:
    """List the 3850 types of generalized Stewart platform.

    KINDS are names such as PL or DPL, A for all angles, D for all distances; LL means both DLL and
    ALL. Bounds are those of the paper and two-sided, except where the name says one_sided. table_3
    is one-sided and counts one orientation of each DLL. A bound has no value if its theorem does
    not apply.

    \b
    Examples:
      gsp enumerate --by-class
      gsp enumerate --class 3D3A --only PH HP A
      gsp enumerate --with PP --max-refined-two-sided 80 --sort refined_two_sided
      gsp enumerate --format csv -o types.csv
      gsp enumerate --coincident "3DLL 3ALL"
    """
    selected = _select(o)
    if o.coincident is not None:
        if o.coincident:
            emit(
                o.output, _patterns(parse_type(o.coincident), o.first), schema="enumerate-patterns"
            )
        else:
            emit(o.output, _sharing(selected), schema="enumerate-sharing")
        return
    if o.sort:
        selected = selected.sorted_by(*_words(o.sort))
    if o.first is not None:
        selected = selected[: o.first]
    if o.by_class:
        emit(o.output, _counts(selected), schema="enumerate-count")
        return
    shown = (
        [listing.column(key) for key in _words(o.columns)] if o.columns else listing.DEFAULT_COLUMNS
    )
    emit(
        o.output,
        Result(
            columns=[
                Field(
                    column.key,
                    column.title,
                    align="right" if column.numeric else "left",
                    essential=column.key in _ESSENTIAL,
                    minor=_MINOR.get(column.key, _MOST_MINOR),
                )
                for column in shown
            ],
            rows=list(selected.rows(shown)),
            notes=_notes(selected, shown),
            part="types",
        ),
        schema="enumerate",
    )


def _notes(selected: listing.TypeList, shown: Sequence[listing.TypeColumn]) -> list[str]:
    """Return how many types are listed, and what Table 3 counts where others count more."""
    notes = [_share(selected)]
    keys = {column.key for column in shown}
    if "table_3" in keys and any(DLL in t.kinds for t in selected if type_bounds(t).table_3):
        notes.append(f"Table 3 counts {ONE_ORIENTATION}; all other columns count both")
    return notes


def _share(selected: listing.TypeList) -> str:
    return f"{len(selected)} of {len(listing.TypeList())} types"


def _words(text: str) -> list[str]:
    return text.replace(",", " ").split()


def _select(o: Options) -> listing.TypeList:
    return listing.TypeList().where(
        classes=[parse_class(name) for text in o.classes for name in _words(text)],
        only=parse_kind_set(o.only) if o.only is not None else None,
        having=[parse_kind_set(word) for word in _words(o.having or "")],
        without=parse_kind_set(o.without) if o.without else frozenset(),
        at_most={
            key.removeprefix("max_"): ceiling
            for key, ceiling in vars(o).items()
            if key.startswith("max_") and ceiling is not None
        },
    )


def _counts(selected: listing.TypeList) -> Result:
    filtered = len(selected) < len(listing.TypeList())

    def rows() -> Iterator[dict[str, Any]]:
        for platform_class in CLASSES:
            members = [t for t in selected if t.platform_class == platform_class]
            yield {
                "class": platform_class.id,
                "formula": _formula(platform_class),
                "types": platform_class.size,
                "selected": len(members),
            }
        yield {
            "class": "all",
            "formula": " + ".join(str(c.size) for c in CLASSES),
            "types": sum(c.size for c in CLASSES),
            "selected": len(selected),
        }

    return Result(
        columns=[
            *FIELDS.of("class formula types"),
            FIELDS["selected"].but(title="selected" if filtered else "enumerated"),
        ],
        rows=list(rows()),
        part="classes",
        notes=[f"{_share(selected)}, as the options select them"] if filtered else [],
    )


def _formula(platform_class: PlatformClass) -> str:
    d, a = platform_class.distances, platform_class.angles
    return (
        f"C({a + 3},{a}) · C({d + 5},{d}) = "
        f"{platform_class.angle_choices} · {platform_class.distance_choices}"
    )


def _sharing(selected: listing.TypeList) -> Result:
    """Count the patterns of shared primitives by class."""
    from gspcli.catalogue.coincidence import count_coincident, count_up_to_swap

    def row(name: str, members: list[GspType]) -> dict[str, Any]:
        return {
            "class": name,
            "types": len(members),
            "patterns": sum(map(count_coincident, members)),
            "up_to_swap": int(sum(map(count_up_to_swap, members))) if closed else None,
        }

    closed = {t.mirrored for t in selected} == set(selected)
    by_class = [(c.id, [t for t in selected if t.platform_class == c]) for c in CLASSES]
    return Result(
        columns=FIELDS.of("class types@2 patterns up_to_swap"),
        rows=[*(row(name, members) for name, members in by_class), row("all", list(selected))],
        part="classes",
        notes=[
            "A pattern says which constraints share a primitive, up to renaming; a pair of",
            "primitives carries no kind twice. All primitives distinct is one pattern of a type.",
        ],
    )


def _patterns(gsp_type: GspType, limit: int | None) -> Result:
    """List the patterns of shared primitives of one type."""
    from gspcli.catalogue.coincidence import coincident_types, count_coincident, over_constraint

    rows = []
    for pattern in islice(coincident_types(gsp_type), limit):
        excess = over_constraint(pattern.bonds)
        rows.append(
            {
                "id": pattern.id,
                "pattern": pattern.notation,
                "platform_primitives": len(pattern.platform_primitives),
                "base_primitives": len(pattern.base_primitives),
                "never_rigid": excess.reason if excess else None,
            }
        )
    return Result(
        columns=FIELDS.of("id pattern platform_primitives base_primitives never_rigid"),
        rows=rows,
        part="patterns",
        title=gsp_type.id,
        notes=[
            f"{len(rows)} of {count_coincident(gsp_type)} patterns",
            "Capitals are primitives of the platform, small letters of the base; - is a distance,",
            "^ an angle.",
        ],
    )
