"""Rebuild the table of peers in the README from docs/benchmarks.md, which `make bench` writes.

python -m benchmarks.peer_table [--check]
"""

from __future__ import annotations

import re
import sys

from benchmarks.markdown import number
from tools.recording import ROOT, parser, save, with_section

README = ROOT / "README.md"
BENCHMARKS = ROOT / "docs" / "benchmarks.md"
#: The peers, by their columns there.
PEERS = {"fkSGP": "fkSGP", "msolve": "msolve", "phc -p": "PHCpack", "M2 track": "Macaulay2"}
#: The cases shown, by their names there.
CASES = {
    "6-6": "hexapod, 40 poses",
    "3D3A PL PL LP": "three distances, three angles, 64 poses",
    "6PL": "six distances of points and lines, 512",
    "6LL": "six distances of lines, 4096",
}
_PROVED = (
    "every pose, and that none is missing",
    "nothing",
    "real poses, up to a probabilistic criterion",
    "nothing",
    "nothing",
)


def peer_table() -> str:
    """Return the table: what is proved, how long it takes, what is lost."""
    times, answers = (_table(heading) for heading in ("solutions | gsp", "instances | gsp found"))
    rows = [["", "gsp", *PEERS.values()], ["---"] * (len(PEERS) + 2), ["proves", *_PROVED]]
    for case, name in CASES.items():
        # A page of before 1.1 has two columns of gsp.
        ours = times[case].get("certified", times[case]["gsp"])
        rows.append([name, ours, *(_ratio(times[case][peer], ours) for peer in PEERS)])
    rows += _machines()
    lost = [_lost(answers["Dietmaier"][peer]) for peer in PEERS]
    rows.append(["of Dietmaier's 40 real poses", answers["Dietmaier"]["real"], *lost])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _machines() -> list[list[str]]:
    """Return the rows of machines that are solved for the first time: fkSGP is mostly quicker."""
    machines = _table("first", "platform").values()
    pairs = {
        row["platform"]: (_seconds(row["first"]), _seconds(row["fkSGP"]))
        for row in machines
        if not row["platform"].startswith("hexagons") and "sampled" not in row["platform"]
    }
    ours = sorted(first for first, _ in pairs.values() if first)
    ratios = sorted(first / theirs for first, theirs in pairs.values() if first and theirs)
    times = f"{number(ours[0] * 1e3)} to {number(ours[-1] * 1e3)} ms"
    least, most = ratios[0], ratios[-1]
    lowest = f"{number(1 / least)} times slower" if least < 1 else number(least)
    quicker = f"{lowest} to {number(most)} times quicker"
    found = [[f"{len(pairs)} real machines, first solve", times, quicker]]
    for row in machines:
        if row["platform"].endswith("sampled machines, median"):
            name = row["platform"].removesuffix(", median")
            first, ratio = _seconds(row["first"]), re.search(r"\(([\d.]+)×\)", row["first"])
            if first and ratio:
                times = f"{number(first * 1e3)} ms"
                x = float(ratio[1])
                quicker = f"{number(x)} times slower" if x > 1 else f"{number(1 / x)} times quicker"
                found.append([f"{name}, first solve, median", times, quicker])
    return [[*row, *["not tried"] * 3] for row in found]


def _table(heading: str, first: str = "case") -> dict[str, dict[str, str]]:
    """Return a table of the page, by case and column."""
    text = BENCHMARKS.read_text(encoding="utf-8")
    found = re.search(
        rf"^\| {first} \| {re.escape(heading)}.*?\n\n", text, re.MULTILINE | re.DOTALL
    )
    assert found is not None, heading
    head, _, *rows = [
        [cell.strip() for cell in line.strip("| ").split(" | ")]
        for line in found[0].strip().splitlines()
    ]
    return {row[0]: dict(zip(head, row, strict=True)) for row in rows}


def _ratio(cell: str, ours: str) -> str:
    """Return how much slower a peer is, or what is said in place of a time."""
    theirs = _seconds(cell)
    if theirs is None or cell.startswith(">"):
        return cell
    return f"{number(theirs / (_seconds(ours) or 1))} times slower"


def _seconds(cell: str) -> float | None:
    """Return the time in a cell, such as ``16 ms (11×)``."""
    found = re.search(r"([\d.]+) (s|ms|µs)\b", cell)
    return float(found[1]) * {"s": 1, "ms": 1e-3, "µs": 1e-6}[found[2]] if found else None


def _lost(cell: str) -> str:
    real = re.search(r"(\d+) real", cell)
    assert real is not None, cell
    return real[1]


def main() -> int:
    """Write or compare the table; return the exit code."""
    arguments = parser(__doc__).parse_args()
    text = with_section(README, "peers", peer_table())
    return save({README: text}, check=arguments.check, confirmed="the table of peers")


if __name__ == "__main__":
    sys.exit(main())
