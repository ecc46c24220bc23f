"""Nearly singular poses at T = 0, where the frames of most machines coincide: none is lost."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest

from gspcli.solver import solve
from gspcli.spec import loads

#: Nearly singular at R = 1, T = 0, which certifies; 36 of the 40 poses are not real.
_SPEC = """
gsp: 1
units: {length: m, angle: deg}
platform:
  Y1: {point: [-2, -1, -3]}
  Y2: {point: [2, 0, 0]}
  Y3: {point: [-2, -3, -3]}
  Y4: {point: [-3, 0, 1]}
  Y5: {point: [-1, 3, 3]}
  Y6: {point: [-3, -2, 1]}
base:
  X1: {point: [4, 1, 0]}
  X2: {point: [-2, -3, 0]}
  X3: {point: [-1, -4, 0]}
  X4: {point: [0, -1, -2]}
  X5: {point: [0, 0, 1]}
  X6: {point: [-3, -2.262242, 2]}
constraints:
  - {distance: [Y1, X1], value: 7}
  - {distance: [Y2, X2], value: 5}
  - {distance: [Y3, X3], value: sqrt(11)}
  - {distance: [Y4, X4], value: sqrt(19)}
  - {distance: [Y5, X5], value: sqrt(14)}
  - {distance: [Y6, X6], value: sqrt(1.068770866564)}
"""


def test_a_nearly_singular_pose_at_the_origin_is_found() -> None:
    result = solve(loads(_SPEC))
    assert result.verdict == "complete"
    assert result.counts.certified == 40
    assert result.counts.real == 4
    at_rest = np.abs(result.T[result.real]).max(axis=1) == 0
    assert at_rest.sum() >= 1
    turned = np.abs(result.R[result.real][at_rest] - np.eye(3)).max(axis=(1, 2))
    assert turned.max() < 1e-6


@pytest.mark.parametrize("shift", ["1e-4", "1e-6", "-3e-7", "1e-8", "1e-10"])
def test_none_is_lost_wherever_the_last_leg_begins(shift: str) -> None:
    """Its foot is moved, its length is still that at R = 1, T = 0: exactly, in decimals."""
    foot = Decimal("-2.262242") + Decimal(shift)
    square = 1 + (foot + 2) ** 2
    spec = _SPEC.replace("-2.262242", f"{foot:f}").replace("1.068770866564", f"{square:f}")
    result = solve(loads(spec))
    assert (result.verdict, result.counts.certified) == ("complete", 40)
    assert (np.abs(result.T[result.real]).max(axis=1) == 0).any()
