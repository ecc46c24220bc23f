"""The list of weakened inequalities: its texts are in the files, and its tests are tests."""

from __future__ import annotations

from dataclasses import replace

from tests.weakened import __main__ as tool


def test_every_text_is_in_its_file_once_and_every_test_exists() -> None:
    listed = tool.mutants()
    assert len(listed) >= 80
    assert list(tool.problems(listed)) == []


def test_one_is_killed_and_what_changes_nothing_is_not(tmp_path) -> None:
    """The tests are run with the changed file, and not with the installed one."""
    one = next(one for one in tool.mutants() if one.name == "isolation-contains-radius")
    copy = tool.Copy(tmp_path)
    assert tool.tried(copy, one) == "killed"
    assert tool.tried(copy, replace(one, new=f"{one.old}  # as before")) == "survives"
