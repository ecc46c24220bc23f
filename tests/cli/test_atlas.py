"""`gsp atlas summary`."""

from __future__ import annotations

import json
from collections.abc import Callable

Run = Callable[..., object]


def test_summary_by_class_and_against_the_bounds(gsp: Run) -> None:
    outcome = gsp("atlas", "summary", "--format", "json")
    assert (outcome.code, outcome.err) == (0, "")
    document = json.loads(outcome.out)
    assert document["schema"] == "gsp.atlas-summary/1"
    counts, bounds = document["counts"], document["bounds"]
    everything = {row["sides"]: row for row in counts if row["name"] == "all"}
    assert [row["types"] for row in counts[:8:2]] == [1120, 1260, 1008, 462]
    assert everything["one-sided"]["largest"] == max(row["largest"] for row in counts)
    by_bound = {(row["bound"], row["name"]): row for row in bounds}
    assert by_bound["table_3", "3D3A"]["sharp"] == 1120
    assert by_bound["theorem_5_4", "all"]["types"] == 35
    assert by_bound["theorem_5_4", "all"]["sharp"] == 0
    assert all(row["largest"] >= row["median"] >= 1 for row in bounds)
