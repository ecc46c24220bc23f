"""Build `data/counts/` and what docs/counts.md shows of it.

    python -m tools.build.counts --work counts.jsonl [--jobs N] [--timeout SECONDS] [--check]
    python -m tools.build.counts --docs [--check]

The first counts everything (hours; it continues from the work file) and writes the data as
`gsp atlas build` does; both draw docs/images/counts.svg and put the tables of `gsp atlas summary`
into the page.
"""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from collections import Counter

from gspcli.catalogue.bounds import type_bounds
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import all_types
from gspcli.cli.main import run
from tools.charts import Bubble, bubble_chart
from tools.recording import ROOT, parser, save, with_section

PAGE = ROOT / "docs" / "counts.md"
PICTURE = ROOT / "docs" / "images" / "counts.svg"

#: Each panel: the bound, and its title.
PANELS = (("theorem_5_3", "Theorem 5.3"), ("refined_two_sided", "refined bound"))


def main() -> int:
    """Build; return the exit code."""
    options = parser(__doc__)
    options.add_argument("--docs", action="store_true", help="leave the data as they are")
    arguments, others = options.parse_known_args()
    check = ["--check"] * arguments.check
    if not arguments.docs:
        folder = str(ROOT / "data" / "counts")
        if code := run(["atlas", "build", "-o", folder, *check, *others]):
            return code
        # This process may have read the old data: draw in another one.
        again = [sys.executable, "-m", "tools.build.counts", "--docs", *check]
        return subprocess.run(again, cwd=ROOT, check=False).returncode
    return save(
        {PICTURE: picture(), PAGE: with_section(PAGE, "gsp atlas summary", tables())},
        check=arguments.check,
        confirmed="tables and picture of counts.md",
    )


def tables() -> str:
    """Return the tables of `gsp atlas summary` in Markdown."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        run(["atlas", "summary", "--format", "markdown"])
    return printed.getvalue()


def picture() -> bytes:
    """Return a plot of bounds against generic counts, both two-sided, over all types."""
    return bubble_chart(
        {title: bubbles(bound) for bound, title in PANELS},
        "svg",
        x_label="bound",
        y_label="generic count, two-sided",
        note="area: number of types; line: the bound is the count",
    )


def bubbles(bound: str) -> list[Bubble]:
    """Return a bubble for all types of a class with the same bound and the same count."""
    types = Counter(
        (type_bounds(t).values()[bound] or 1, generic_counts(t).two_sided, t.platform_class.id)
        for t in all_types()
    )
    return [Bubble(top, count, number, name) for (top, count, name), number in types.items()]


if __name__ == "__main__":
    sys.exit(main())
