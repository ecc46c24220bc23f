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
    "atlas": "atlas_summary",
    "dynamics": "inverse_dynamics",
    "export": "exported",
    # A function of Python's own; and results that were named before they were commands.
    "enumerate": "TypeList",
    "constraint": "constraint_facts",
    "realize": "mechanism",
    # A word of Python's own.
    "import": "import_machine",
}
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
        "atlas": gspcli.atlas_summary(),
        "bound": gspcli.bound(gspcli.parse_type("3D3A PP PL LL ALL ALL ALL")),
        "check": gspcli.check(instance_files()[SPEC]),
        "derive": gspcli.derive("PSC"),
        "show": gspcli.show(gspcli.parse_type("6PP")),
        "table": gspcli.table(3),
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
    for command in COMMANDS:
        name = OTHERWISE.get(command, command.replace("-", "_"))
        assert name in gspcli.__all__, command
        assert callable(getattr(gspcli, name))
    assert set(OTHERWISE) <= set(COMMANDS)
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
        "scan": [*results["scan"].found.numbers.values()],
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
        ("atlas", "atlas summary"),
        ("bound", "bound 3D3A PP PL LL ALL ALL ALL"),
        ("check", "check SPEC"),
        ("derive", "derive csp"),
        ("show", "show 6PP"),
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


#: What rows are called, what was claimed, and further results; and the account of paths: a
#: platform that was solved before needs none.
_ADDED = {"file", "account", "row", "t", "mode", "number", "claimed_real", "claimed_sides", "home"}


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


def test_the_table_of_the_paper_is_that_of_the_command(gsp: Callable) -> None:
    document = json.loads(gsp("table", "3", "--format", "json").out)
    assert document["tables"] == [gspcli.table(3).to_json()]
    with pytest.raises(gspcli.ArgumentError, match="number: found 4"):
        gspcli.table(4)


def test_mistakes_in_files_are_told_one_by_one(tmp_path) -> None:
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("constraints: 5\n")
    found = gspcli.check(instance_files()[SPEC], wrong, tmp_path / "none.yaml")
    assert [one.valid for one in found.files] == [True, False, False]
    assert not found.valid
    assert repr(found) == "<CheckResult: 3 files, 2 with mistakes, 0 warnings>"
    entry = found.to_json()["files"][1]
    assert entry["file"] == str(wrong)
    assert entry["problems"][0]["line"] == 1


@pytest.mark.parametrize(
    ("target", "options"),
    [("mjcf", []), ("mjcf", ["--mode", "2"]), ("msolve", ["--coordinates", "rt"]), ("sympy", [])],
)
def test_what_is_exported_is_what_the_command_writes(
    gsp: Callable, hexapod, target: str, options: list[str]
) -> None:
    mode = 2 if "--mode" in options else None
    found = gspcli.exported(
        hexapod, target, mode=mode, coordinates="rt" if "rt" in options else "study"
    )
    outcome = gsp("export", f"@{SPEC}", "--to", target, *options)
    assert outcome.out == str(found)
    assert outcome.err == "".join(f"{note}\n" for note in found.notes)
    assert repr(found).startswith(f"<Export to {target}: 1 file, ")


def test_a_controller_is_two_files(gsp: Callable, hexapod, tmp_path) -> None:
    found = gspcli.exported(hexapod, "c", name="my-legs")
    assert gsp("export", f"@{SPEC}", "--to", "c", "-o", tmp_path / "my-legs.c").code == 0
    assert {".c", ".h"} == set(found.files)
    for suffix, text in found.files.items():
        assert (tmp_path / f"my-legs{suffix}").read_text() == text


def test_exports_that_do_not_exist_are_refused(hexapod) -> None:
    for arguments, message in (
        ({"target": "step"}, "target: found 'step', expected "),
        (
            {"target": "msolve", "coordinates": "euler"},
            "coordinates: found 'euler', expected study,",
        ),
        ({"target": "msolve", "digits": 0}, "digits: found 0, "),
        ({"target": "mjcf", "mode": 99}, "found mode 99, expected one of the "),
    ):
        with pytest.raises(gspcli.GspError, match=message):
            gspcli.exported(hexapod, **arguments)


def test_a_search_is_that_of_the_command(gsp: Callable) -> None:
    gsp_type = gspcli.parse_type("3D3A PH PH PH ALL ALL ALL")
    found = gspcli.maximize_real(gsp_type, attempts=1, real=8)
    outcome = gsp("maximize-real", "3D3A", "PH", "PH", "PH", "--attempts", "1", "--real", "8")
    assert outcome.out == gspcli.dumps(found.instance) == found.to_json()["spec"]
    assert found.real == gspcli.solve(found.instance).counts.real
    with pytest.raises(gspcli.ArgumentError, match="real: found 0"):
        gspcli.maximize_real(gsp_type, real=0)


def test_a_view_is_a_page_or_a_drawing(hexapod) -> None:
    result = gspcli.solve(hexapod)
    assert gspcli.view(hexapod) == gspcli.view(result, mode=result.home.number)
    assert gspcli.view(result).startswith(b"<!doctype html>")
    assert len(gspcli.view(result, live=True)) > len(gspcli.view(result)) + 200_000
    with pytest.raises(gspcli.ArgumentError, match="expected html"):
        gspcli.view(result, "svg", live=True)
    drawn = gspcli.view(result, "svg", mode=2, seen_from=(20, 40), names=False)
    assert drawn != gspcli.view(result, "svg", names=False)
    assert drawn.startswith(b"<?xml")
    for arguments, message in (({"fmt": "gif"}, "fmt: found 'gif'"), ({"mode": 99}, "mode 99")):
        with pytest.raises(gspcli.GspError, match=message):
            gspcli.view(result, **arguments)


def test_shipped_instances_have_names(hexapod) -> None:
    assert gspcli.example(SPEC) == gspcli.example(f"@{SPEC}") == hexapod
    with pytest.raises(gspcli.GspError, match="did you mean octahedral-3-3"):
        gspcli.example("octahedral33")
