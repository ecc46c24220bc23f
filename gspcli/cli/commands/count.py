"""`gsp count`: how many solutions a platform has, exactly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import (
    Command,
    Options,
    Positive,
    output_options,
    seed_option,
    value_options,
)
from gspcli.cli.render import Output, emit
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import Changes, load_instance, read_type
from gspcli.cli.streams import progress
from gspcli.defaults import LONG_COUNT
from gspcli.errors import NotFiniteError
from gspcli.wording import shown

if TYPE_CHECKING:
    from gspcli.catalogue.types import GspType
    from gspcli.certification.counting import ExactCount
    from gspcli.geometry.instance import Instance

FIELDS = Fields("count")

_COLUMNS = FIELDS.of(
    "spec type_count geometry_count exact_count distinct finite proof geometry_proof"
)
_GEOMETRY_COLUMNS = FIELDS.of("geometry count distinct meaning proof@2")
_LEGEND = (
    "type: the count of almost every platform of the type; geometry: of this geometry with almost "
    "all values; exact: of this platform, with multiplicities; all for the sides asked for"
)


@click.command(cls=Command)
@click.argument("specs", metavar="[SPEC]...", nargs=-1)
@value_options
@click.option("--type", "type_name", metavar="TYPE", help="Count random platforms of a type.")
@click.option(
    "--geometry",
    "geometries",
    metavar="CLASS,...",
    default="generic",
    show_default=True,
    help="With --type: the classes of geometry to count, or all.",
)
@click.option(
    "--effort",
    default=LONG_COUNT,
    show_default=True,
    type=Positive(),
    metavar="BILLIONS",
    help="Stop after this many multiplications; a billion takes a second or two.",
)
@seed_option(": the prime, and random platforms")
@output_options()
def command(o: Options) -> None:
    """Count the complex solutions of a platform exactly, without finding them.

    SPEC is an instance file, - for standard input, or @NAME of an example (`gsp example`); its
    numbers are taken as written. Three counts are printed: of the type (almost every platform of
    it), of the geometry (this one, with almost all values), and of this platform. The last is given
    with multiplicities and without, and says whether the solutions are finitely many. Counts are
    computed by linear algebra modulo a random prime. Beside each stands whether it is proved, or a
    bound of the probability that the prime made it wrong.

    With --type it counts random platforms with special geometries instead: planar, hexagons,
    3-3, 6-4, congruent and others (--geometry all). Those of joints are for 6PP only. A generic
    geometry that is too large to count has the generic count, which is proved for its type.

    The exit code is 3 if the solutions of a SPEC are infinitely many, and 4 if they could not be
    counted.

    \b
    Examples:
      gsp count platform.yaml
      gsp count @planar-hexagons @dietmaier --format json
      gsp count --type 6PP --geometry planar,hexagons,3-3
      gsp count --type "6D PP PP PH PH PH PL" --geometry generic,planar
    """
    if (o.type_name is None) == (not o.specs):
        raise click.UsageError("give either SPEC or --type")
    if o.type_name is not None:
        if o.changes != Changes():
            raise click.UsageError("--set and --delta change the values of SPEC: --type has none")
        _count_geometries(read_type([o.type_name]), o.geometries, o.effort, o.seed, o.output)
    else:
        _count_specs(o.specs, o.changes, o.effort, o.seed, o.output)


def _count_specs(
    specs: tuple[str, ...], changes: Changes, limit: float, seed: int, output: Output
) -> None:
    from gspcli.certification.counting import NotCountedError
    from gspcli.certification.counting.platform_counts import count_platform

    instances = [load_instance(spec, changes) for spec in specs]
    rows, documents, refusals, infinite = [], [], [], []
    for spec, instance in progress(
        list(zip(specs, instances, strict=True)), total=len(specs), label="counting solutions"
    ):
        found = count_platform(instance, seed=seed, effort=limit)
        if found.refusal:
            refusals.append(f"{spec}: {found.refusal}")
        if found.exact is not None and not found.exact.finite:
            infinite.append(spec)
        documents.append(found.to_json())
        rows.append(_row(spec, instance, found.exact, found.geometry))
    document: Any = documents[0] if len(documents) == 1 else documents
    emit(output, Result(_COLUMNS, rows, notes=[_LEGEND]), document=document)
    if refusals:
        raise NotCountedError("\n".join(refusals))
    if infinite:
        raise NotFiniteError(f"infinitely many complex solutions: {', '.join(infinite)}")


def _row(
    spec: str, instance: Instance, exact: ExactCount | None, geometry: ExactCount | None
) -> dict[str, Any]:
    from gspcli.certification.counting.platform_counts import proof_text

    row: dict[str, Any] = {"spec": spec, "type_count": instance.expected}
    if geometry is not None:
        row |= {"geometry_count": geometry.solutions, "geometry_proof": proof_text(geometry.error)}
    if exact is not None:
        row |= {
            "exact_count": exact.solutions,
            "distinct": exact.distinct,
            "finite": exact.finite,
            "proof": proof_text(exact.error),
        }
    return row


def _count_geometries(
    gsp_type: GspType, names: str, limit: float, seed: int, output: Output
) -> None:
    from gspcli.atlas.platform_counts import count_type, possible_geometries

    possible = possible_geometries(gsp_type)
    chosen = possible if names == "all" else [name.strip() for name in names.split(",")]
    for name in chosen:
        if name not in possible:
            raise click.BadParameter(
                f"found --geometry {shown(name)}, expected of {gsp_type.id}: {', '.join(possible)}"
            )

    def shown_progress(these: Sequence[str]) -> Iterable[str]:
        return progress(these, total=len(these), label="counting solutions")

    found = count_type(gsp_type, chosen, limit, seed, shown_progress)
    table = Result(_GEOMETRY_COLUMNS, found.rows(), title=gsp_type.id)
    emit(output, table, document=found.to_json())
