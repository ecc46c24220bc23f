"""The list of weakened inequalities: its texts are in the files, and its tests are tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import ModuleType

import pytest


@pytest.fixture(scope="module")
def tool(load_tool: Callable[[str], ModuleType]) -> ModuleType:
    return load_tool("verify.mutants")


def test_every_text_is_in_its_file_once_and_every_test_exists(tool: ModuleType) -> None:
    listed = tool.mutants()
    assert len(listed) >= 80
    assert list(tool.problems(listed)) == []


def test_what_is_wrong_with_an_entry_is_said(tool: ModuleType) -> None:
    one = tool.mutants()[0]
    file = one.tests[0].partition("::")[0]

    def said(**changes: object) -> list[str]:
        return [text.partition(": ")[2] for text in tool.problems([replace(one, **changes)])]

    assert said() == []
    assert said(old="no such text") == [f"the text occurs 0 times in {one.file}, expected once"]
    assert said(old="\n")[0].endswith(f"times in {one.file}, expected once")
    assert said(file="no/such/file") == ["the text occurs 0 times in no/such/file, expected once"]
    assert said(new=one.old) == ["found no change, no reason or no test"]
    assert said(tests=()) == ["found no change, no reason or no test"]
    for test in (f"{file}::test_no_such", "tests/no_such.py::test_it"):
        assert said(tests=(test,)) == [f"no such test: {test}"]
    assert list(tool.problems([one, one])) == [f"{one.name}: the name occurs twice"]


def test_one_is_killed_and_what_changes_nothing_is_not(tool: ModuleType, tmp_path) -> None:
    """The tests are run with the changed file, and not with the installed one."""
    one = next(one for one in tool.mutants() if one.name == "isolation-contains-radius")
    copy = tool.Copy(tmp_path)
    assert tool.tried(copy, one) == "killed"
    assert tool.tried(copy, replace(one, new=f"{one.old}  # as before")) == "survives"


def test_what_is_not_tried_again_stays_as_it_is_recorded(tool: ModuleType) -> None:
    listed = tool.mutants()
    first, changed, *_ = listed
    others = [first, replace(changed, proves="Another reason."), replace(first, name="new")]
    assert tool._recorded(others) == {
        first.name: "killed",
        changed.name: "not tried",
        "new": "not tried",
    }
