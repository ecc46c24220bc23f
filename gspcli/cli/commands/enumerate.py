"""`gsp enumerate`: the catalogue of types."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from typing import Any

import click

from gspcli.catalogue.bounds import ONE_ORIENTATION, type_bounds
from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.listing import COLUMNS, DEFAULT_COLUMNS, TypeList, column
from gspcli.catalogue.types import CLASSES, GspType, PlatformClass
from gspcli.cli.options import Command, Options, Whole, option, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result

FIELDS = Fields("enumerate")

#: Options that take several words, as in `--only PL PH A`.
_WORD_LISTS = ("--only", "--with", "--without", "--columns", "--sort")


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
    for one in reversed([c for c in COLUMNS if c.numeric]):
        name, said = f"max_{one.key}", f"Keep types whose {one.key} is at most N."
        function = option(f"--{name.replace('_', '-')}", said, type=Whole(0))(function)
    return function


@click.command(cls=_WordListCommand)
@option(
    "--class CLASS",
    f"Keep a class: {', '.join(c.id for c in CLASSES)}. Repeatable.",
    name="classes",
    multiple=True,
)
@option("--only KINDS", "Keep types made of these kinds alone.")
@option("--with KINDS", "Keep types that have each of these.", name="having")
@option("--without KINDS", "Drop types that have any of these.")
@_ceilings
@option("--sort COLUMNS", "Sort by columns; -COLUMN is descending.")
@option("--columns COLUMNS", "Show these columns, in this order.")
@option("--first", "Show the first N rows.", type=Whole(0))
@option("--by-class", "Count by class, beside Proposition 2.2.")
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
    if o.coincident:
        result = _patterns(o.coincident, o.first)
    elif o.coincident is not None:
        result = _sharing(_select(o))
    elif o.by_class:
        result = _counts(_select(o)[: o.first])
    else:
        result = _types(_select(o)[: o.first], o.columns)
    emit(o.output, result)


def _words(text: str | None) -> list[str]:
    return (text or "").replace(",", " ").split()


def _select(o: Options) -> TypeList:
    """Return the types that the options select, sorted."""
    ceilings = {key.removeprefix("max_"): n for key, n in vars(o).items() if key[:4] == "max_"}
    found = TypeList().where(
        classes=_words(" ".join(o.classes)),
        only=o.only,
        having=_words(o.having),
        without=o.without or frozenset(),
        at_most={key: ceiling for key, ceiling in ceilings.items() if ceiling is not None},
    )
    return found.sorted_by(*_words(o.sort))


def _types(selected: TypeList, keys: str | None) -> Result:
    """Return the facts about types, and what Table 3 counts where others count more."""
    shown = [column(key) for key in _words(keys)] or DEFAULT_COLUMNS
    names = [one.key for one in shown]
    notes = [f"{len(selected)} of {len(TypeList())} types"]
    if "table_3" in names and any(DLL in t.kinds for t in selected if type_bounds(t).table_3):
        notes.append(f"Table 3 counts {ONE_ORIENTATION}; all other columns count both")
    columns, rows = FIELDS.of(" ".join(names)), list(selected.rows(shown))
    return Result(columns, rows, notes=notes, part="types", schema="enumerate")


def _counts(selected: TypeList) -> Result:
    rows: list[dict[str, Any]] = []
    for one, members in _by_class(selected):
        d, a = one.distances, one.angles
        formula = f"C({a + 3},{a}) · C({d + 5},{d}) = {one.angle_choices} · {one.distance_choices}"
        row = {"class": one.id, "formula": formula}
        rows.append({**row, "types": one.size, "selected": len(members)})
    total = sum(one.size for one in CLASSES)
    sizes = " + ".join(str(one.size) for one in CLASSES)
    rows.append({"class": "all", "formula": sizes, "types": total, "selected": len(selected)})
    columns, notes = FIELDS.of("class@2 formula types selected"), []
    if len(selected) == total:
        columns[-1] = columns[-1].but(title="enumerated")
    else:
        notes = [f"{len(selected)} of {total} types, as the options select them"]
    return Result(columns, rows, notes=notes, part="classes", schema="enumerate-count")


def _by_class(selected: TypeList) -> list[tuple[PlatformClass, list[GspType]]]:
    return [(one, [t for t in selected if t.platform_class == one]) for one in CLASSES]


def _sharing(selected: TypeList) -> Result:
    """Count the patterns of shared primitives by class."""
    from gspcli.catalogue.coincidence import count_coincident, count_up_to_swap

    def row(name: str, members: list[GspType]) -> dict[str, Any]:
        swapped = int(sum(map(count_up_to_swap, members))) if closed else None
        patterns = sum(map(count_coincident, members))
        return {"class": name, "types": len(members), "patterns": patterns, "up_to_swap": swapped}

    closed = {t.mirrored for t in selected} == set(selected)
    rows = [row(one.id, members) for one, members in _by_class(selected)]
    rows.append(row("all", list(selected)))
    notes = [
        "A pattern says which constraints share a primitive, up to renaming; a pair of",
        "primitives carries no kind twice. All primitives distinct is one pattern of a type.",
    ]
    columns = FIELDS.of("class@2 types@2 patterns@2 up_to_swap")
    return Result(columns, rows, notes=notes, part="classes", schema="enumerate-sharing")


def _patterns(name: str, limit: int | None) -> Result:
    """List the patterns of shared primitives of one type."""
    from gspcli.catalogue.coincidence import coincident_types, count_coincident, over_constraint
    from gspcli.catalogue.names import parse_type

    gsp_type = parse_type(name)
    rows = []
    for pattern in islice(coincident_types(gsp_type), limit):
        excess = over_constraint(pattern.bonds)
        row: dict[str, Any] = {"id": pattern.id, "pattern": pattern.notation}
        row["platform_primitives"] = len(pattern.platform_primitives)
        row["base_primitives"] = len(pattern.base_primitives)
        rows.append({**row, "never_rigid": excess.reason if excess else None})
    notes = [
        f"{len(rows)} of {count_coincident(gsp_type)} patterns",
        "Capitals are primitives of the platform, small letters of the base; - is a distance,",
        "^ an angle.",
    ]
    columns = FIELDS.of("id@2 pattern platform_primitives base_primitives never_rigid")
    form = "enumerate-patterns"
    return Result(columns, rows, gsp_type.id, notes, part="patterns", schema=form)
