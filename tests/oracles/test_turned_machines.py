"""Special machines in turned frames are as complete as they were when they were recorded."""

from __future__ import annotations

import pytest

from tests.support.turned_machines import DECIMALS, SORTS, answer, is_as_complete, names, recorded

_SORTS = list(SORTS)


@pytest.mark.parametrize("written", ["doubles" if x is None else str(x) for x in DECIMALS])
@pytest.mark.parametrize("sort", _SORTS)
def test_special_machines_in_turned_frames_are_as_complete(sort: str, written: str) -> None:
    own = [name for name in names() if name.startswith(f"{sort}/{written}/")]
    name = own[(3 * _SORTS.index(sort) + len(written)) % len(own)]
    assert is_as_complete(answer(name), recorded()[name])


def test_all_machines_are_recorded() -> None:
    assert list(recorded()) == list(names())
