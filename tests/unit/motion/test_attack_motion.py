from __future__ import annotations

import copy

import numpy as np
import pytest

import gspcli
from gspcli.resources import data_path

#: Two modes meet and vanish between the first rows.
ROWS = np.array(
    [[0, 2.53, 2.08, 0.93, 1.97, 1.46, 1.73], [1, 2.6, 2.0, 1.0, 1.9, 1.46, 1.73]], float
)
NAMES = ["t", "1", "2", "3", "4", "5", "6"]


@pytest.fixture(scope="module")
def tool(load_tool):
    return load_tool("fuzz.motion")


@pytest.fixture(scope="module")
def given(tool):
    return tool.Attack(gspcli.load(data_path("examples", "platform-6-6.yaml")), ROWS, NAMES)


@pytest.fixture(scope="module")
def document(tool, given):
    return tool.track(given, "json")[1]


def test_a_right_answer_passes(tool, given):
    assert list(tool.problems(given)) == []


def spoil_pose(document):
    document["poses"][0]["x"] += 1e-3


def lose_mode(document):
    document["poses"].pop()


def lose_event(document):
    document["events"].pop()


def move_event(document):
    document["events"][0]["t"] = [1.5, 1.5]


@pytest.mark.parametrize("spoil", [spoil_pose, lose_mode, lose_event, move_event])
def test_a_wrong_answer_is_noticed(tool, given, document, spoil):
    wrong = copy.deepcopy(document)
    spoil(wrong)
    assert [*tool._accounts(given, wrong), *tool._poses(given, wrong)]


@pytest.mark.parametrize("what", ["nan", "", "x", "1,2"])
def test_a_spoilt_cell_is_told(tool, given, what):
    spoilt = tool.Attack(given.instance, given.rows, NAMES, cell=(1, 2, what))
    assert list(tool.problems(spoilt)) == []
