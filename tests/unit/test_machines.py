"""The comparison of what machines print sees what it is for (`tools/verify/machines.py`)."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tools.recording import ROOT
from tools.verify.machines import FAST, differences
from tools.verify.machines import MACHINES as BY_NAME

TABLE = "mode  f [Hz]\n   1    12.3\n"
CSV = "x,condition\n1.00000000001,36.9821\n2.5,8.1\n"


def test_equal_outputs_do_not_differ() -> None:
    assert differences(TABLE, TABLE) == []


def test_one_blank_more_in_a_table_is_a_difference() -> None:
    assert differences(TABLE, TABLE.replace("f [Hz]", " f [Hz]"))


def test_last_digits_of_doubles_in_json_are_none_but_those_of_conditions_are() -> None:
    poses = {"T": [1.5, 2.0, 1e-17], "condition": 36.9821}
    other = {"T": [1.5 + 1e-13, 2.0, -1e-17], "condition": 36.9821}
    assert differences(json.dumps(poses), json.dumps(other)) == []
    worse = other | {"condition": 36.9822}
    assert differences(json.dumps(poses), json.dumps(worse)) == [
        "condition: 36.9821 is not 36.9822"
    ]
    moved = other | {"T": [1.5 + 1e-6, 2.0, 0.0]}
    assert len(differences(json.dumps(poses), json.dumps(moved))) == 1


def test_the_same_holds_for_csv() -> None:
    assert differences(CSV, CSV.replace("1.00000000001", "1.00000000002")) == []
    assert differences(CSV, CSV.replace("36.9821", "36.9822"))
    assert differences(CSV, CSV.replace("2.5", "2.6"))


def test_a_number_is_compared_with_the_largest_of_its_row_and_column() -> None:
    rows = [{"x": 130.0, "n": 1}, {"x": 0.005, "n": 2}]
    other = [{"x": 130.0, "n": 1}, {"x": 0.005 + 1e-8, "n": 2}]
    assert differences(json.dumps(rows), json.dumps(other)) == []
    assert differences(json.dumps(rows[1:]), json.dumps(other[1:]))


def test_numbers_of_steps_may_differ() -> None:
    assert differences('{"parts": 753, "modes": [1]}', '{"parts": 755, "modes": [1]}') == []
    assert differences('{"parts": 753, "modes": [1]}', '{"parts": 755, "modes": [2]}')


def test_the_scene_of_a_page_is_compared_as_data() -> None:
    page = '<p>8 modes</p>\n<script type="application/json" id="scene">{"T": [1.5]}</script>\n'
    assert differences(page, page.replace("1.5", "1.5000000000001")) == []
    assert differences(page, page.replace("1.5", "1.6")) == ["T: 1.5 is not 1.6"]
    assert differences(page, page.replace("8", "7")) == ["'<p>8 modes</p>' is not '<p>7 modes</p>'"]


@pytest.mark.parametrize("machine", BY_NAME)
def test_the_kernel_has_the_build_of_its_machine(machine: str) -> None:
    code = "from gspcli import _kernel; print(_kernel.build())"
    environment = {"GSP_BUILD": BY_NAME[machine]["GSP_BUILD"]}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        assert "this processor has no build named" in done.stderr
        pytest.skip(f"this processor cannot run {machine}")
    assert done.stdout.strip() == machine


def test_pages_that_are_run_quickly_exist() -> None:
    names = {path.name for path in (ROOT / "docs").glob("*.md")} | {"README.md"}
    assert set(FAST) <= names
