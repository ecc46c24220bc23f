"""The figures of walks that docs/controller.md states are those of the record."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Machines with cranks or slides: of the others the kernel judges every step.
RAILS = ("modified-paradex", "6-PUS", "6-PUS inverted", "mixed")
HEADS = ("reachy-mini-head", "t-top-head")


def test_figures_of_walks_are_those_of_the_record() -> None:
    with (ROOT / "data" / "verification" / "controllers.csv").open(encoding="utf-8") as stream:
        rows = {row["name"]: row for row in csv.DictReader(stream)}
    others = [name for name in rows if name not in RAILS + HEADS]

    def number(column: str, names: Iterable[str] = rows) -> int:
        return sum(int(rows[name][column]) for name in names)

    def total(column: str, names: Iterable[str] = rows) -> str:
        # Numbers of four digits are written without a space.
        found = number(column, names)
        return f"{found:_}".replace("_", " ") if found > 9999 else str(found)

    text = " ".join((ROOT / "docs" / "controller.md").read_text(encoding="utf-8").split())
    refused = 100 * number("refused") / number("steps")
    for sentence in (
        f"in {total('proved')} proved steps",
        f"{total('judged', others)} are on the branch that the kernel follows",
        f"It could not judge {total('beyond')}.",
        f"The last poses of {total('solved')} walks",
        f"Over rails are {total('proved', RAILS)} of the steps",
        f"({total('proved', HEADS)} steps)",
        f"{total('judged', RAILS + HEADS)} comparisons",
        f"Refused were {total('refused')} steps ({refused:.2g} %)",
    ):
        assert sentence in text, sentence
    assert number("different") == number("unsolved") == 0
