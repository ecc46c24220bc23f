"""Build `data/counts/` and what docs/counts.md shows of it.

    python tools/build_counts.py --work counts.jsonl [--jobs N] [--timeout SECONDS] [--check]
    python tools/build_counts.py --docs [--check]

The first counts everything (hours; taken up again from the work file) and writes the data as
`gsp atlas build` does; both draw docs/images/counts.svg and put the tables of `gsp atlas summary`
into the page.
"""

from __future__ import annotations

import contextlib
import io
import math
import subprocess
import sys
from collections import Counter

from recording import ROOT, parser, save

sys.path.insert(0, str(ROOT))

from gspcli.catalogue.bounds import type_bounds
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import CLASSES, all_types
from gspcli.cli.main import run

PAGE = ROOT / "docs" / "counts.md"
PICTURE = ROOT / "docs" / "images" / "counts.svg"
BEGIN, END = "<!-- gsp atlas summary -->\n", "<!-- end -->\n"

#: Each panel: the bound, and its title.
PANELS = (("theorem_5_3", "Theorem 5.3"), ("refined_two_sided", "refined bound"))
COLOURS = dict(
    zip((c.id for c in CLASSES), ("#0072b2", "#e69f00", "#009e73", "#cc3311"), strict=True)
)
LEFT, TOP, GAP, STEP = 64, 40, 60, 27
#: Powers of two at the ends of the axes; one is STEP wide.
LOW, WIDEST, HIGHEST = 3, 18, 13
WIDTH, HEIGHT = STEP * (WIDEST - LOW), STEP * (HIGHEST - LOW)


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
        again = [sys.executable, __file__, "--docs", *check]
        return subprocess.run(again, check=False).returncode
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    page = f"{before}{BEGIN}\n{tables()}\n{END}{after}"
    return save(
        {PICTURE: picture(), PAGE: page},
        check=arguments.check,
        confirmed="tables and picture of counts.md",
    )


def tables() -> str:
    """Return the tables of `gsp atlas summary` in Markdown."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        run(["atlas", "summary", "--format", "markdown"])
    return printed.getvalue()


def picture() -> str:
    """Return a plot of bounds against generic counts, both two-sided, over all types."""
    width = LEFT + len(PANELS) * (WIDTH + GAP)
    height = TOP + HEIGHT + 84
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="12" fill="#222">',
        "<title>Bounds against generic counts of all 3850 types</title>",
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    for index, (bound, title) in enumerate(PANELS):
        parts += panel(LEFT + index * (WIDTH + GAP), bound, title)
    parts.append(
        f'<text transform="translate(16 {TOP + HEIGHT / 2}) rotate(-90)" text-anchor="middle">'
        "generic count, two-sided</text>"
    )
    for index, (name, colour) in enumerate(COLOURS.items()):
        x = LEFT + 100 * index
        parts.append(f'<circle cx="{x + 6}" cy="{height - 18}" r="6" fill="{colour}"/>')
        parts.append(f'<text x="{x + 18}" y="{height - 14}">{name}</text>')
    parts.append(
        f'<text x="{LEFT + 420}" y="{height - 14}">area: number of types; '
        "line: the bound is the count</text>"
    )
    return "\n".join([*parts, "</svg>", ""])


def panel(left: float, bound: str, title: str) -> list[str]:
    """Return the elements of one panel."""

    def x(value: float) -> float:
        return round(left + STEP * (math.log2(value) - LOW), 1)

    def y(value: float) -> float:
        return round(TOP + STEP * (HIGHEST - math.log2(value)), 1)

    low, high = 2**LOW, 2**HIGHEST
    parts = [
        f'<text x="{left + WIDTH / 2}" y="{TOP - 14}" text-anchor="middle" '
        f'font-weight="bold">{title}</text>',
        f'<text x="{left + WIDTH / 2}" y="{TOP + HEIGHT + 38}" text-anchor="middle">bound</text>',
        f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>',
        f'<path d="M{x(low)} {y(low)}L{x(high)} {y(high)}" stroke="#888" stroke-dasharray="4 3"/>',
    ]
    for power in range(LOW, WIDEST + 1, 3):
        at = x(2**power)
        parts.append(
            f'<path d="M{at} {TOP}v{HEIGHT}" stroke="#eee"/>'
            f'<text x="{at}" y="{TOP + HEIGHT + 18}" text-anchor="middle">{2**power}</text>'
        )
    for power in range(LOW, HIGHEST + 1, 3):
        at = y(2**power)
        parts.append(
            f'<path d="M{left} {at}h{WIDTH}" stroke="#eee"/>'
            f'<text x="{left - 6}" y="{at + 4}" text-anchor="end">{2**power}</text>'
        )
    points = Counter(
        (type_bounds(t).values()[bound], generic_counts(t).two_sided, t.platform_class.id)
        for t in all_types()
    )
    # Large circles first, so that they cover no small ones.
    for (top, count, name), types in sorted(points.items(), key=lambda item: -item[1]):
        parts.append(
            f'<circle cx="{x(top or 1)}" cy="{y(count)}" r="{0.9 * math.sqrt(types):.1f}" '
            f'fill="{COLOURS[name]}" fill-opacity="0.6"/>'
        )
    return parts


if __name__ == "__main__":
    sys.exit(main())
