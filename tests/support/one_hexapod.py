"""One hexapod that tests write in the formats of other programs, and read back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gspcli.machines.api import ImportedMachine

#: Joints of a hexapod, and its pose: no turn, 100 above the base.
BASE = np.array(
    [[85, 120, 0], [85, -120, 0], [62.5, -134, 1], [-147, -13, 0], [-147, 13, 2], [62.5, 134, 0]]
)
PLATFORM = np.array(
    [[90, 15, 0], [90, -15, 3], [-32, -85, 0], [-58, -70, 0], [-58, 70, 0], [-32, 85, 5]]
)
UP = np.array([0, 0, 100])
LENGTHS = np.linalg.norm(PLATFORM + UP - BASE, axis=1)

Write = Callable[..., ImportedMachine]


def same(found: ImportedMachine, scale: float = 1.0, *, home: bool = True) -> None:
    rows = found.instance.constraints
    assert [row.kind.name for row in rows] == ["DPP"] * 6
    order = [int(np.abs(BASE * scale - row.base.point).max(axis=1).argmin()) for row in rows]
    assert sorted(order) == list(range(6))
    for k, row in zip(order, rows, strict=True):
        assert np.allclose(row.base.point, BASE[k] * scale, atol=1e-9 * scale)
        assert np.allclose(row.platform.point, PLATFORM[k] * scale, atol=1e-9 * scale)
        assert row.value.value == pytest.approx(LENGTHS[k] * scale, abs=1e-9)
    if home:
        assert np.allclose(found.instance.home.T, [0, 0, 100 * scale])
    else:
        assert found.instance.home is None
