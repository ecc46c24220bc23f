"""Each command is a function of its name in `gspcli`, and its JSON is that of the result."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gspcli
from gspcli.cli.commands import COMMANDS
from gspcli.resources import instance_files

#: Commands whose function has another name, and why.
OTHERWISE = {
    # These are names of packages.
    "atlas": "TypeList",
    "dynamics": "inverse_dynamics",
    "export": "dumps",
    # Those of the catalogue take types, and were functions before they were commands.
    "bound": "type_bounds",
    "constraint": "constraint_facts",
    "enumerate": "TypeList",
    "realize": "mechanism",
    "show": "type_bounds",
    # A file is read, and its warnings come with it; a shipped one is loaded; a page is shown.
    "check": "read",
    "example": "load",
    "view": "notebook_view",
}
#: What is done from the shell only: the paper's tables and closed forms, and a search.
SHELL = {"derive", "maximize-real", "table"}
SPEC = "octahedral-3-3"


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.load(instance_files()[SPEC])


@pytest.fixture(scope="module")
def poses(hexapod):
    found = gspcli.solve(hexapod)
    return found.R[found.real].real, found.T[found.real].real


@pytest.fixture(scope="module")
def results(hexapod, poses) -> dict[str, Any]:
    R, T = poses
    values = [[row.value.value * factor for row in hexapod.constraints] for factor in (1, 1.001)]
    heavy = gspcli.load(instance_files()["workspace-study"])
    home = gspcli.solve(heavy)
    return {
        "analyze": gspcli.analyze(hexapod, R, T, load=[0, 0, -1], stiffness=2, tolerance=1e-3),
        "certify": gspcli.certify(hexapod, R, T),
        "clearance": gspcli.clearance(hexapod, R[:1], T[:1]),
        "count": gspcli.count(hexapod),
        "measure": gspcli.measure(hexapod, R, T),
        "sample": gspcli.sample(gspcli.parse_type("3D3A PH PH PH ALL ALL ALL"), 20),
        "scan": gspcli.scan(hexapod, {1: [1, 1.5, 2]}),
        "sensors": gspcli.sensors(hexapod),
        "solve": gspcli.solve(hexapod),
        "track": gspcli.track(hexapod, values),
        "workspace": gspcli.workspace(
            heavy, home.R[0].real, home.T[0].real, free=("z",), tolerance=0.5
        ),
    }


def test_every_command_is_a_function() -> None:
    for command in set(COMMANDS) - SHELL:
        name = OTHERWISE.get(command, command.replace("-", "_"))
        assert name in gspcli.__all__, command
        assert callable(getattr(gspcli, name))
    assert SHELL | set(OTHERWISE) <= set(COMMANDS)
    assert not {name for name in OTHERWISE if callable(getattr(gspcli, name, None))}


def test_results_are_tables_data_and_one_line(results) -> None:
    for name, result in results.items():
        assert len(result.to_frame()), name
        assert json.loads(json.dumps(result.to_json())), name
        text = repr(result)
        assert "\n" not in text, name
        assert text.startswith("<"), name
        assert text.endswith(">"), name


def test_arrays_of_results_are_read_only(results) -> None:
    arrays = {
        "analyze": [results["analyze"].given.jacobian, results["analyze"].reactions],
        "clearance": [results["clearance"].lower, results["clearance"].upper],
        "measure": [results["measure"]],
        "scan": [results["scan"].found.modes, results["scan"].found.conditions],
        "solve": [results["solve"].R, results["solve"].T],
        "track": [results["track"].R, results["track"].T, results["track"].values],
    }
    for name, those in arrays.items():
        for array in those:
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
            assert isinstance(array, np.ndarray), name


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("analyze", "analyze SPEC POSES --load 0,0,-1 --stiffness 2 --tolerance 1e-3"),
        ("certify", "certify SPEC POSES"),
        ("clearance", "clearance SPEC FIRST"),
        ("count", "count SPEC"),
        ("measure", "measure SPEC POSES"),
        ("sample", "sample 3D3A PH PH PH --count 20"),
        ("scan", "scan SPEC --vary 1=1:2:3 --jobs 1"),
        ("sensors", "sensors SPEC"),
        ("solve", "solve SPEC"),
        ("track", "track SPEC VALUES"),
        ("workspace", "workspace @workspace-study --mode 1 --over z --gap 0.5 --all-parts"),
    ],
)
def test_the_json_of_a_command_is_that_of_its_function(
    gsp: Callable, results, hexapod, poses, tmp_path, name: str, words: str
) -> None:
    R, T = poses
    files = {"POSES": tmp_path / "poses.csv", "FIRST": tmp_path / "first.csv"}
    rows = np.concatenate((T, R.reshape(-1, 9)), axis=1)
    head = ",".join(["Tx", "Ty", "Tz", *(f"r{i}{j}" for i in "123" for j in "123")])
    for path, those in zip(files.values(), (rows, rows[:1]), strict=True):
        lines = [",".join(map(repr, row)) for row in those.tolist()]
        path.write_text("\n".join([head, *lines]) + "\n")
    files["VALUES"] = tmp_path / "values.csv"
    stated = np.array([row.value.value for row in hexapod.constraints])
    lines = [",".join(map(repr, (stated * factor).tolist())) for factor in (1, 1.001)]
    files["VALUES"].write_text("\n".join(["1,2,3,4,5,6", *lines]) + "\n")
    for word, path in files.items():
        words = words.replace(word, str(path))
    outcome = gsp(*words.replace("SPEC", f"@{SPEC}").split(), "--format", "json")
    assert outcome.code == 0, outcome.err
    assert _near(json.loads(outcome.out), json.loads(json.dumps(results[name].to_json())))


#: What rows are called, what was claimed, and what is asked besides; and what became of paths: a
#: platform that was solved before needs none.
_ADDED = {"account", "row", "t", "mode", "number", "claimed_real", "claimed_sides", "home"}


def _near(shell: Any, python: Any) -> bool:
    """Return whether all numbers of a result are in the document of the command."""
    if isinstance(python, dict):
        return all(key in shell and _near(shell[key], python[key]) for key in set(python) - _ADDED)
    if isinstance(python, list):
        return len(shell) == len(python) and all(map(_near, shell, python))
    if isinstance(python, float) and isinstance(shell, float):
        # Poses that went through text are rotations to the last digit but one.
        return shell == pytest.approx(python, rel=1e-6, abs=1e-9)
    return bool(shell == python)
