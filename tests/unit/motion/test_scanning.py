from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.motion.scanning import Axis, crossings, scan
from gspcli.resources import data_path


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.load(data_path("examples", "platform-6-6.yaml"))


def test_counts_are_those_of_solve_and_change_at_proved_folds(hexapod):
    axis = Axis(0, tuple(np.linspace(2.3, 2.8, 11).tolist()))
    found = scan(hexapod, [axis])
    assert found.modes.shape == (11,)
    for value, modes in zip(axis.values, found.modes, strict=True):
        one = gspcli.solve(gspcli.set_values(hexapod, [f"1={value!r}"]), certify=False)
        assert one.real.sum() == modes
    edges = list(found.edges)
    folds = list(crossings(found))
    assert len(folds) == len(edges) > 0
    for (low, high), crossed in zip(edges, folds, strict=True):
        change = sum(fold.change for fold in crossed)
        assert change == found.modes[high] - found.modes[low]
        for fold in crossed:
            (value,) = fold.values
            assert axis.values[low[0]] <= value <= axis.values[high[0]]
            sides = [
                gspcli.solve(
                    gspcli.set_values(hexapod, [f"1={value + step!r}"]), certify=False
                ).real.sum()
                for step in (-1e-7, 1e-7)
            ]
            assert sides[1] - sides[0] == fold.change


def test_two_values(hexapod):
    axes = [Axis(0, (2.4, 2.5, 2.6)), Axis(3, (1.9, 2.0))]
    found = scan(hexapod, axes)
    assert found.modes.shape == found.conditions.shape == (3, 2)
    one = gspcli.set_values(hexapod, ["1=2.6", "4=2.0"])
    assert found.modes[2, 1] == gspcli.solve(one, certify=False).real.sum()
    assert found.values_at((2, 1)).tolist() == [2.6, 2.08, 0.93, 2.0, 1.46, 1.73]


@pytest.mark.parametrize("axes", [[], [Axis(0, (1.0, 2.0))] * 2])
def test_mistakes_are_named(hexapod, axes):
    with pytest.raises(ArgumentError, match="axes: expected one or two different"):
        scan(hexapod, axes)
