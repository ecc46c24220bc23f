from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification import certify, refine
from gspcli.errors import IncompleteError


@pytest.mark.parametrize("names", ["DPP DPP DPP DPP DPP DPP", "DPL DLP DLL DPH AHL ALL"])
@pytest.mark.parametrize("digits", [3, 17, 60])
def test_decimals_agree_with_the_exact_solution(names: str, digits: int, known: Callable) -> None:
    platform = known(names, 31)
    R, T = platform.floats
    certificate = certify(platform.instance, [R], [T])[0]
    refined = refine(platform.instance, certificate, digits)
    half = Fraction(51, 100)
    for texts, exact in zip(refined.R, platform.R, strict=True):
        for text, value in zip(texts, exact, strict=True):
            assert abs(Fraction(text) - value) <= half / 10**digits
            assert len(text.partition(".")[2]) == digits
    places = {len(text.partition(".")[2]) for text in refined.T}
    assert len(places) == 1
    for text, value in zip(refined.T, platform.T, strict=True):
        assert abs(Fraction(text) - value) <= half / 10 ** places.copy().pop()
    largest = max(refined.T, key=lambda text: abs(Decimal(text)))
    assert len(largest.lstrip("-0.").replace(".", "")) == digits
    assert refined.R_imag is None


def test_a_solution_that_is_not_real_has_imaginary_parts(tangent: Callable) -> None:
    instance = tangent(1 - Fraction(1, 10**20))
    z = 1.4142135623730951e-10j
    certificate = certify(instance, [np.eye(3)], [[1, 0, z]])[0]
    refined = refine(instance, certificate, 30)
    assert refined.T == ("1." + "0" * 29, "0." + "0" * 29, "0." + "0" * 29)
    # sqrt(1 - d^2), of which the sign is that of the candidate.
    assert refined.T_imag is not None
    square = Fraction(refined.T_imag[2]) ** 2
    assert abs(square - (1 - (1 - Fraction(1, 10**20)) ** 2)) < Fraction(1, 10**38)
    assert refined.T_imag[2].startswith("0.0000000001414213562")


def test_another_instance_is_not_refined(tangent: Callable) -> None:
    certificate = certify(tangent(Fraction(2)), [np.eye(3)], [[1, 0, 3**0.5]])[0]
    assert certificate.certified
    with pytest.raises(IncompleteError, match="10 digits could not be proved"):
        refine(tangent(Fraction(3)), certificate, 10)


def test_refining_nothing_is_refused(tangent: Callable) -> None:
    instance = tangent(Fraction(1))
    certificate = certify(instance, [np.eye(3)], [[1, 0, 0]])[0]
    with pytest.raises(ValueError, match="nothing to refine"):
        refine(instance, certificate, 10)
