"""One random trajectory written in many ways is one to `gsp measure` and `gsp track`."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest

from tests.support.fuzz import motion_files


@pytest.fixture(scope="module")
def given():
    return motion_files.attack(16, np.random.default_rng(5))


@pytest.fixture(scope="module")
def document(given, tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    spec, path = folder / "p.yaml", folder / "v.csv"
    spec.write_text(given.spec(radians=False), encoding="utf-8")
    rng = np.random.default_rng(1)
    file = motion_files.written(given, "values", rng, radians=False)
    path.write_bytes(file.text(rng))
    words = [str(spec), str(path), "--complete", "--format", "json", *file.options]
    code, out, _ = motion_files.call("track", *words)
    return {"code": code, **json.loads(out)}


@pytest.mark.parametrize("seed", [5, 6])
def test_a_trajectory_is_the_same_however_it_is_written(seed):
    rng = np.random.default_rng(seed)
    assert list(motion_files.problems(motion_files.attack(16, rng), rng)) == []


def move_pose(document):
    document["poses"][0]["x"] += 1e-3


def lose_pose(document):
    document["poses"].pop()


def change_code(document):
    document["code"] += 1


@pytest.mark.parametrize("spoil", [move_pose, lose_pose, change_code])
def test_a_difference_is_noticed(document, spoil):
    wrong = copy.deepcopy(document)
    spoil(wrong)
    assert list(motion_files.differences(document, wrong))


def test_the_place_of_a_cell():
    assert motion_files.place('1, "22",3', ",", 1) == 5
    assert motion_files.place("1 22 3", " ", 2) == 6
