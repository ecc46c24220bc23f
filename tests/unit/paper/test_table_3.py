"""Table 3: generated from the surfaces, compared with the print, confirmed by solving."""

from __future__ import annotations

from collections import Counter

import pytest

from gspcli.errors import CheckFailed
from gspcli.paper import confirmation, table3


def test_the_56_triples_by_case() -> None:
    cases = Counter(entry.surfaces for entry in table3.compute())
    assert cases == {
        "PPP": 10, "PPC": 12, "PPS": 6, "SSS": 1, "PSS": 3,
        "PCC": 9, "SSC": 2, "PSC": 6, "CCC": 4, "SCC": 3,
    }  # fmt: skip
    assert sum(cases.values()) == 56


def test_n1_depends_on_the_case_alone() -> None:
    printed = {(entry.surfaces, entry.n1) for entry in table3.printed()}
    assert printed == {(entry.surfaces, entry.n1) for entry in table3.compute()}
    assert len(printed) == 10


def test_two_columns_are_misprinted() -> None:
    found = [(d.row, d.printed, d.computed) for d in table3.differences()]
    assert found == [
        ("case PSS", "PP PP PP", "PP PP PH"),
        ("case CCC", "LP LP LL", "LP LP LP"),
    ]


def test_every_entry_is_confirmed_by_solving() -> None:
    done = confirmation.confirm(instances=1, seed=7)
    assert done == confirmation.Confirmation(families=56, instances=56)


def test_a_wrong_entry_is_not_confirmed(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = table3.compute()
    wrong = table3.Entry(entries[0].n1 * 2, entries[0].surfaces, entries[0].distances)
    monkeypatch.setattr(confirmation, "compute", lambda: [wrong])
    with pytest.raises(CheckFailed, match="Table 3 says 32"):
        confirmation.confirm(instances=1)
