"""The misprints in the formulas of Section 6 are proved, and the proofs can fail."""

import pytest

from gspcli.errors import CheckFailed
from gspcli.symbolic import printed_sections
from gspcli.symbolic.closed_forms import derive


@pytest.mark.parametrize(
    ("proof", "words"),
    [
        (printed_sections.equation_12, "linearly independent modulo h1"),
        (printed_sections.equation_14, "wrong by 2(p2 − p1)"),
        (printed_sections.equation_16, "d1(x − z)"),
        (printed_sections.equation_18, "exchanged"),
    ],
)
def test_proofs(proof, words):
    assert words in proof()


def test_a_proof_fails_where_there_is_nothing_to_prove(monkeypatch):
    """With s4 and s6 chosen so that l3 = m3, the coefficient z24 of r32⁴ is 0."""
    angles = printed_sections._ANGLES
    monkeypatch.setitem(angles, "m3", angles["l3"])
    h2 = derive("AAA").at(angles)[1]
    assert h2.degree(h2.ring.gens[0]) == 3
    with pytest.raises(CheckFailed, match="the rank is 7"):
        printed_sections.equation_12()
