"""Rebuild the table and the picture of what is on record in docs/real-counts.md.

python -m tools.build.real_page [--check]
"""

from __future__ import annotations

import sys
from collections import Counter

from gspcli.catalogue.counts import best_real, family_counts, real_counts
from gspcli.catalogue.types import CLASSES, families
from tools.charts import Bubble, bubble_chart
from tools.recording import ROOT, parser, save

PAGE = ROOT / "docs" / "real-counts.md"
PICTURE = ROOT / "docs" / "images" / "real-families.svg"
BEGIN, END = "<!-- what is on record -->\n", "<!-- end of what is on record -->\n"
#: Area of a bubble for one family.
WEIGHT = 9.0


def table() -> str:
    """Return a row for each class, in Markdown."""
    lines = [
        "| class | families | with a witness | all solutions real | mean share | least share"
        " | every even number up to the best |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for one in CLASSES:
        known = [(best_real(f), family_counts(f).two_sided) for f in families(one)]
        shares = [real / count for real, count in known if real is not None]
        every = sum(len(real_counts(f)) == (best_real(f) or 0) // 2 + 1 for f in families(one))
        lines.append(
            f"| {one} | {len(known)} | {len(shares)} | {sum(share == 1 for share in shares)}"
            f" | {sum(shares) / len(shares):.2f} | {min(shares):.2f} | {every} |"
        )
    return "\n".join(lines)


def picture() -> bytes:
    """Return the largest known numbers over the generic counts; for 3D3A they are the same."""
    panels = {}
    for one in CLASSES[1:]:
        spots = Counter((family_counts(f).two_sided, best_real(f) or 1) for f in families(one))
        panels[str(one)] = [
            Bubble(count, best, WEIGHT * times, "all" if best == count else "some, at least")
            for (count, best), times in spots.items()
        ]
    return bubble_chart(
        panels,
        "svg",
        x_label="solutions (generic count, both sides)",
        y_label="largest known number of real ones",
        note="areas: families of the same numbers",
    )


def main() -> int:
    """Write or compare the table and the picture; return the exit code."""
    arguments = parser(__doc__).parse_args()
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    return save(
        {PAGE: f"{before}{BEGIN}\n{table()}\n\n{END}{after}", PICTURE: picture()},
        check=arguments.check,
        confirmed="table and picture of what is on record of real solutions",
    )


if __name__ == "__main__":
    sys.exit(main())
