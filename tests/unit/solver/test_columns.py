"""Every column is said once, and the frame and the CSV have the same ones."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.errors import GspError
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.solver.results.columns import COLUMNS, ROTATIONS, rotation_columns
from gspcli.spec import load


def test_the_frame_has_the_columns_in_their_order() -> None:
    result = solve(load(instance_files()["six-planes"]))
    frame = result.to_frame(everything=True)
    assert list(frame.columns) == [column.key for column in COLUMNS]
    for column in COLUMNS:
        assert len(column.read(result)) == len(result.R)


def test_angles_of_poses_that_are_not_real_are_no_numbers() -> None:
    result = solve(load(instance_files()["six-planes"]))
    for form in ("rotvec", "zxy"):
        for column in rotation_columns(form):
            np.testing.assert_array_equal(np.isfinite(column.read(result)), result.real)


@pytest.mark.parametrize("form", ["", "XYX", "xYz", "euler"])
def test_unknown_forms_are_told_the_known_ones(form: str) -> None:
    with pytest.raises(GspError, match="or one of " + ", ".join(ROTATIONS)):
        rotation_columns(form)
