"""Tables 1 and 2: what is printed against what is derived."""

from __future__ import annotations

from collections import Counter

import pytest

from gspcli.errors import CheckFailed
from gspcli.paper import errata
from gspcli.paper.tables import (
    Entry,
    differences,
    differences_3,
    printed_table,
    printed_table_3,
    table_1,
    table_2,
    table_3,
)


def test_table_1_has_one_wrong_sign():
    (difference,) = differences(1, table_1())
    assert (difference.row, difference.column) == ("solution 8", "r21")
    assert difference.printed == "(3-sqrt(5))/(2*(-1+sqrt(5)))"
    assert difference.computed == "(1 - sqrt(5))/4"


def test_the_print_of_table_1_is_no_rotation_in_row_8():
    """The proof that needs no derivation: its first two columns are not perpendicular."""
    from sympy import radsimp, sympify

    row = {name: sympify(text) for name, text in printed_table(1)[7].items()}
    product = sum(row[f"r{i}1"] * row[f"r{i}2"] for i in (1, 2, 3))
    assert radsimp(product).expand() != 0
    row["r21"] = -row["r21"]
    product = sum(row[f"r{i}1"] * row[f"r{i}2"] for i in (1, 2, 3))
    assert radsimp(product).expand() == 0


def test_table_2_is_that_of_exchanged_distances():
    found = list(differences(2, table_2()))
    places = {(f"solution {i}", unknown) for i in range(1, 9) for unknown in "xy"}
    assert {(d.row, d.column) for d in found} == places
    assert not list(differences(2, table_2(6, 5, 4)))


def test_the_print_of_table_2_is_not_on_the_cylinders():
    from sympy import sympify

    for row in printed_table(2):
        x, y, z = (sympify(row[name]) for name in "xyz")
        assert (x**2 + y**2, x**2 + z**2, y**2 + z**2) == (36, 25, 16)


def test_sizes():
    assert [len(row) for row in printed_table(1)] == [9] * 8
    assert [len(row) for row in printed_table(2)] == [3] * 8


# Table 3: generated from the surfaces, compared with the print, confirmed by solving.


def test_the_56_triples_by_case() -> None:
    cases = Counter(entry.surfaces for entry in table_3())
    assert cases == {
        "PPP": 10, "PPC": 12, "PPS": 6, "SSS": 1, "PSS": 3,
        "PCC": 9, "SSC": 2, "PSC": 6, "CCC": 4, "SCC": 3,
    }  # fmt: skip
    assert sum(cases.values()) == 56


def test_n1_depends_on_the_case_alone() -> None:
    printed = {(entry.surfaces, entry.n1) for entry in printed_table_3()}
    assert printed == {(entry.surfaces, entry.n1) for entry in table_3()}
    assert len(printed) == 10


def test_two_columns_are_misprinted() -> None:
    found = [(d.row, d.printed, d.computed) for d in differences_3()]
    assert found == [("case PSS", "PP PP PP", "PP PP PH"), ("case CCC", "LP LP LL", "LP LP LP")]


def test_every_entry_is_confirmed_by_solving() -> None:
    done = errata.confirm(instances=1, seed=7)
    assert done == errata.Confirmation(families=56, instances=56)


def test_a_wrong_entry_is_not_confirmed(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = table_3()
    wrong = Entry(entries[0].n1 * 2, entries[0].surfaces, entries[0].distances)
    monkeypatch.setattr(errata, "table_3", lambda: [wrong])
    with pytest.raises(CheckFailed, match="Table 3 says 32"):
        errata.confirm(instances=1)
