"""Counting by tracking paths."""

from __future__ import annotations

import pytest

from tools.atlas.tasks import Task, Tracked


@pytest.mark.parametrize("sides", [1, 2])
def test_tracking_counts_certified_poses(sides: int) -> None:
    task = Task("DPP DPP DPP DPL DPH", sides, 0)
    found = task.run()
    assert isinstance(found, Tracked)
    assert found.certified == task.expected
    assert (found.trace is None) == (sides == 2)
    assert found.trace is None or found.trace.passed


def test_general_quadrics_are_not_tracked() -> None:
    with pytest.raises(ValueError, match="platforms only"):
        Task("ssssss", 1, 0).run()
