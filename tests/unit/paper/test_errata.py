"""Every erratum is proved, and every difference of a table has one."""

from __future__ import annotations

import re

import pytest

from gspcli.errors import CheckFailed
from gspcli.paper import errata
from gspcli.paper.errata import ERRATA, Erratum, prove
from gspcli.paper.tables import Difference, erratum_of, table, table_1


@pytest.mark.parametrize("erratum", ERRATA, ids=lambda erratum: erratum.key)
def test_every_erratum_is_proved(erratum: Erratum) -> None:
    assert len(prove(erratum)) > 20


@pytest.mark.parametrize("erratum", ERRATA, ids=lambda erratum: erratum.key)
def test_numbers_of_an_erratum_are_those_of_its_proof(erratum: Erratum) -> None:
    """Where a number of the paper is wrong, the proof computes the right one."""
    if erratum.sort == "wrong":
        evidence = set(re.findall(r"\d+", prove(erratum)))
        stated = set(re.findall(r"(?<![√\d])\d{2,}", erratum.correct))
        assert stated <= evidence


@pytest.mark.parametrize("number", [1, 2, 3])
def test_every_difference_has_an_erratum(number: int) -> None:
    comparison = table(number)
    assert not comparison.unexplained
    keys = {erratum.key for erratum in ERRATA}
    assert {erratum_of(difference) for difference in comparison.differences} <= keys


def test_another_difference_has_none() -> None:
    assert erratum_of(Difference(1, "solution 1", "r21", "0", "1")) is None
    assert erratum_of(Difference(3, "case PPP", "N1 = 8", "PH PH PH", "PH PH HP")) is None


def test_keys_are_unique() -> None:
    assert len({erratum.key for erratum in ERRATA}) == len(ERRATA)


def test_a_proof_fails_when_the_print_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    (sign,) = (erratum for erratum in ERRATA if erratum.key == "table-1-sign")
    right = table_1()
    monkeypatch.setattr(errata, "printed_table", lambda number: right)
    with pytest.raises(CheckFailed, match="table-1-sign is not proved"):
        prove(sign)
