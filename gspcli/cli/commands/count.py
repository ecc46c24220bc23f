"""`gsp count`: how many solutions a platform has, exactly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import click

from gspcli.cli import options
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import load_instance, read_type
from gspcli.cli.streams import Item, progress
from gspcli.defaults import LONG_COUNT
from gspcli.errors import NotFiniteError
from gspcli.wording import shown

FIELDS = Fields("count")

_COLUMNS = FIELDS.of(
    "spec type_count geometry_count exact_count distinct finite proof geometry_proof"
)
_LEGEND = (
    "type: the count of almost every platform of the type; geometry: of this geometry with almost "
    "all values; exact: of this platform, with multiplicities; all for the sides asked for"
)


@click.command(cls=options.Command)
@options.exclusive("SPEC", "--type")
@options.without("--type", "--set", "--delta")
@click.argument("specs", metavar="[SPEC]...", nargs=-1)
@options.value_options
@options.option("--type TYPE", "Count random platforms of a type.", name="type_name")
@options.option(
    "--geometry CLASS,...",
    "With --type: the classes of geometry to count, or all.",
    name="geometries",
    default="generic",
)
@options.option(
    "--effort BILLIONS",
    "Stop after this many multiplications; a billion takes a second or two.",
    default=LONG_COUNT,
    type=options.Positive(),
)
@options.seed_option(": the prime, and random platforms")
@options.output_options()
def command(o: options.Options) -> None:
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
    if o.type_name is not None:
        _count_geometries(o)
        return
    if not o.specs:
        raise click.UsageError("give either SPEC or --type")
    from gspcli.certification.counting import NotCountedError
    from gspcli.certification.counting.exact_counts import count_platform, proof_text

    instances = [load_instance(spec, o.changes) for spec in o.specs]
    rows, documents, refusals, infinite = [], [], [], []
    for spec, instance in _progress(list(zip(o.specs, instances, strict=True))):
        result = count_platform(instance, seed=o.seed, effort=o.effort)
        exact, geometry = result.exact, result.geometry
        row: dict[str, Any] = {"spec": spec, "type_count": instance.expected}
        if geometry is not None:
            proof = proof_text(geometry.error)
            row |= {"geometry_count": geometry.solutions, "geometry_proof": proof}
        if exact is not None:
            row |= {"exact_count": exact.solutions, "distinct": exact.distinct}
            row |= {"finite": exact.finite, "proof": proof_text(exact.error)}
        rows.append(row)
        documents.append(result.to_json())
        refusals += [f"{spec}: {result.refusal}"] if result.refusal else []
        infinite += [spec] if exact is not None and not exact.finite else []
    document: Any = documents[0] if len(documents) == 1 else documents
    emit(o.output, Result(_COLUMNS, rows, notes=[_LEGEND]), document=document)
    if refusals:
        raise NotCountedError("\n".join(refusals))
    if infinite:
        raise NotFiniteError(f"infinitely many complex solutions: {', '.join(infinite)}")


def _progress(items: Sequence[Item]) -> Iterable[Item]:
    return progress(items, total=len(items), label="counting solutions")


def _count_geometries(o: options.Options) -> None:
    """Count random platforms of a type, with special geometries."""
    from gspcli.atlas.platform_counts import count_type, possible_geometries

    gsp_type = read_type([o.type_name])
    possible = possible_geometries(gsp_type)
    chosen = possible
    if o.geometries != "all":
        chosen = [name.strip() for name in o.geometries.split(",")]
    for name in chosen:
        if name not in possible:
            raise click.BadParameter(
                f"found --geometry {shown(name)}, expected of {gsp_type.id}: {', '.join(possible)}"
            )
    result = count_type(gsp_type, chosen, o.effort, o.seed, _progress)
    columns = FIELDS.of("geometry count distinct meaning proof@2")
    emit(o.output, Result(columns, result.rows(), gsp_type.id), document=result.to_json())
