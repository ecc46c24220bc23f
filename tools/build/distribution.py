"""Sample random 6-6 platforms and show how many poses are real in docs/real-counts.md.

    python -m tools.build.distribution [--check] [--jobs N]

What `gsp sample 6PP --count 100000` finds, as a table and a picture.
"""

from __future__ import annotations

import csv
import sys
from collections import Counter

from gspcli.catalogue.names import parse_type
from gspcli.cli.commands.sample import histogram
from gspcli.cli.streams import progress
from gspcli.reality.real_distribution import Sample, Tally, sample
from tools.recording import ROOT, add_workers, parser, save, with_section, workers_of

PAGE = ROOT / "docs" / "real-counts.md"
PICTURE = ROOT / "docs" / "images" / "real-6-6.svg"
OTHERS = ROOT / "data" / "verification" / "platforms-6-6.csv"
#: This many real poses or more are one cell of the test.
RARE = 14
WANTED = Sample(parse_type("6PP"), 100_000)


def recorded() -> Counter[int]:
    """Return the distribution over the platforms with which completeness is verified."""
    real: Counter[int] = Counter()
    with OTHERS.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            for entry in row["real"].split():
                poses, _, times = entry.partition(":")
                real[int(poses)] += int(times)
    return real


def chi_squared(first: Counter[int], second: Counter[int]) -> tuple[float, int]:
    """Return how much two samples of the same size differ, and the degrees of freedom."""
    cells: dict[int, list[int]] = {}
    for k in first.keys() | second.keys():
        cell = cells.setdefault(min(k, RARE), [0, 0])
        cell[0] += first[k]
        cell[1] += second[k]
    return sum((a - b) ** 2 / (a + b) for a, b in cells.values()), len(cells) - 1


def table(tally: Tally) -> str:
    """Return the distribution in Markdown."""
    others = recorded()
    decided = tally.real.total()
    lines = ["| real poses | platforms | share | others |", "|---:|---:|---:|---:|"]
    lines += [
        f"| {real} | {tally.real[real]} | {100 * tally.real[real] / decided:.3f} % "
        f"| {others[real]} |"
        for real in sorted(tally.real.keys() | others.keys())
    ]
    mean = sum(k * times for k, times in others.items()) / others.total()
    difference, freedom = chi_squared(tally.real, others)
    assert tally.mean is not None
    note = (
        f"{tally.platforms} platforms, {tally.mean:.3f} real poses on average; "
        f"{tally.undecided} undecided, {tally.incomplete} incomplete. Others: "
        f"{others.total()}, {mean:.3f} on average; chi-squared {difference:.1f} "
        f"with {freedom} degrees of freedom."
    )
    return "\n".join([*lines, "", note, ""])


def main() -> int:
    """Write or compare the table and the picture; return the exit code."""
    options = parser(__doc__)
    add_workers(options)
    arguments = options.parse_args()
    tally = Tally()
    pieces = sample(WANTED, workers_of(arguments))
    for part in progress(pieces, total=len(WANTED.pieces), label="solving platforms"):
        tally.add(part)
    return save(
        {
            PAGE: with_section(PAGE, "gsp sample 6PP", table(tally)),
            PICTURE: histogram(WANTED, tally, "svg"),
        },
        check=arguments.check,
        confirmed=f"real poses of {tally.platforms} random 6-6 platforms",
    )


if __name__ == "__main__":
    sys.exit(main())
