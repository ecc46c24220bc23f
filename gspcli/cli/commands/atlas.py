"""`gsp atlas`: summarizes the generic counts of all types."""

from __future__ import annotations

import click

from gspcli.cli.options import Command, Options, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result

FIELDS = Fields("atlas summary")


@click.group
def command() -> None:
    """Show the generic counts of all types, and what confirms them.

    A generic count is what almost every platform of a type has over the complex numbers. All
    are proved (docs/counts.md). Each was confirmed in two ways: by Gröbner bases of random
    platforms modulo two primes (msolve), and by tracking paths to a random real platform. There
    the poses are proved to be different, and traces test that none is missing.
    """


@command.command(cls=Command)
@output_options(parts=("counts", "bounds"))
def summary(o: Options) -> None:
    """Summarize the generic counts by class, and how sharp the bounds are.

    \b
    Examples:
      gsp atlas summary
      gsp atlas summary --format markdown
    """
    from gspcli.atlas.count_summary import atlas_summary, trace_extremes
    from gspcli.catalogue.counts import Method, all_families, family_counts

    found = atlas_summary().to_json()
    confirmed = [family_counts(family).confirmed for family in all_families()]
    notes = ["All counts are proved, see docs/counts.md."]
    notes += [
        f"{sum(method in found for found in confirmed)} of {len(confirmed)} families were "
        f"confirmed by {method.meaning}"
        for method in Method
    ]
    defect, without_one = trace_extremes()
    apart = f"defect at most {defect:.0e}, without one pose at least {without_one:.0e}"
    notes.append(f"trace tests: {apart}")
    columns = FIELDS.of("name sides types smallest median largest of_largest different")
    counts = Result(columns, found["counts"], "Generic counts", notes, part="counts")
    notes = [
        "sharp: the bound is the count; factor: the bound over the count. Table 3 counts",
        "one of the two planes of a DLL and is compared with that count.",
    ]
    columns = FIELDS.of("bound name types sharp median@2 largest@2 of_largest")
    title = "Bounds against generic counts"
    bounds = Result(columns, found["bounds"], title, notes, part="bounds")
    emit(o.output, [counts, bounds], document=found)
