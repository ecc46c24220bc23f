"""`gsp maximize-real`: search, targets, resumption, instance files, the best known platform."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gspcli.reality import real_search
from gspcli.reality.real_search import Solved
from gspcli.spec import dumps, loads


def _real(gsp, text: str, tmp_path: Path) -> int:
    path = tmp_path / "again.yaml"
    path.write_text(text)
    return json.loads(gsp("solve", path, "--format", "json").out)["counts"]["real"]


def test_a_witness_has_the_poses_it_claims(gsp, tmp_path: Path) -> None:
    done = gsp("maximize-real", "3D3A PP PH HP ALL ALH AHH", "--time", "100", "--attempts", "1")
    assert done.code == 0
    first, last = done.err.splitlines()
    assert first.startswith("attempt 0: ")
    claimed = int(last.removesuffix(" real poses, certified"))
    assert loads(done.out).type.id == "DPP DPH DHP ALL ALH AHH"
    assert loads(done.out).name == f"3D3A PP PH HP with {claimed} real poses"
    assert _real(gsp, done.out, tmp_path) == claimed


def test_a_target_that_is_not_reached_is_exit_code_1(gsp) -> None:
    done = gsp("maximize-real", "3D3A PP PP PP ALL ALL ALL", "--real", "17", "--attempts", "1")
    assert done.code == 1
    assert "17 real poses were asked for" in done.err
    assert done.out.startswith("gsp: 1\n")


def test_a_state_is_continued(gsp, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state = tmp_path / "state.json"
    name = "3D3A PP PP PP ALL ALL ALL"
    done = gsp("maximize-real", name, "--real", "2", "--attempts", "1", "--resume", state)
    assert done.code == 0
    assert json.loads(state.read_text())["attempts"] == 1

    def never(*_: object) -> None:
        pytest.fail("an attempt that is done is made again")

    monkeypatch.setattr(real_search.Search, "attempt", never)
    again = gsp("maximize-real", name, "--real", "2", "--attempts", "1", "--resume", state)
    assert again.code == 0
    assert again.out == done.out
    assert gsp("maximize-real", name, "--seed", "5", "--resume", state).code == 2


def test_an_instance_file_is_where_the_search_begins(gsp, tmp_path: Path) -> None:
    path = tmp_path / "given.yaml"
    given = gsp("new", "3D3A", "PP", "PP", "PP", "ALL", "AHH", "ALH").out
    path.write_text(given)
    before = _real(gsp, given, tmp_path)
    done = gsp("maximize-real", path, "--attempts", "1")
    assert done.code == 0
    assert _real(gsp, done.out, tmp_path) >= before
    assert [c.kind for c in loads(done.out).constraints] == [
        c.kind for c in loads(given).constraints
    ]


def test_an_interruption_writes_the_best_so_far(gsp, monkeypatch: pytest.MonkeyPatch) -> None:
    real_attempt = real_search.Search.attempt

    def attempt(self: real_search.Search, number: int) -> Solved | None:
        if number:
            raise KeyboardInterrupt
        return real_attempt(real_search.Search(self.kinds, starts=2, steps=2), 0)

    monkeypatch.setattr(real_search.Search, "attempt", attempt)
    done = gsp("maximize-real", "6PP", "--jobs", "1")
    assert done.code == 130
    assert done.out.startswith("gsp: 1\n")

    def at_once(self: real_search.Search, number: int) -> Solved | None:
        raise KeyboardInterrupt

    monkeypatch.setattr(real_search.Search, "attempt", at_once)
    done = gsp("maximize-real", "6PP", "--jobs", "1")
    assert (done.code, done.out) == (130, "")
    assert done.err == "interrupted before the end of an attempt\n"


def test_the_best_known_platform_is_shown(gsp, tmp_path: Path) -> None:
    done = gsp("maximize-real", "3D3A", "PH", "PH", "PP", "ALL", "AHH", "ALH", "--show")
    assert done.code == 0
    assert done.err == ""
    instance = loads(done.out)
    assert instance.type.id == "DPP DPH DPH ALL ALH AHH"
    assert dumps(instance) == done.out
    best = json.loads(gsp("bound", instance.type.id, "--format", "json").out)["best_real"]
    assert _real(gsp, done.out, tmp_path) == best


def test_a_family_has_the_witness_of_its_types(gsp) -> None:
    assert loads(gsp("maximize-real", "3D3A PH PH PP", "--show").out).type.id == (
        "DPP DPH DPH ALL ALL ALL"
    )


def test_errors(gsp, tmp_path: Path) -> None:
    done = gsp("maximize-real", "6PP", "--show", "--attempts", "3", "--jobs", "2")
    assert (done.code, done.out) == (2, "")
    assert "--attempts and --jobs: not with --show" in done.err
    for option in ("--resume", "-o"):
        done = gsp("maximize-real", "6PP", option, tmp_path)
        assert (done.code, done.out) == (2, "")
        assert "is a directory" in done.err.lower()
    assert gsp("maximize-real", "7PP").code == 2
    assert gsp("maximize-real", "nowhere.yaml").code == 2
    assert gsp("maximize-real", "6PP", "--time", "0").code == 2


def test_a_platform_with_a_known_number_of_poses_is_shown(gsp, tmp_path: Path) -> None:
    done = gsp("maximize-real", "6PP", "--show", "--real", "0")
    assert done.code == 0
    assert loads(done.out).name == "6D PP PP PP PP PP PP with 0 real poses"
    assert _real(gsp, done.out, tmp_path) == 0
    assert gsp("maximize-real", "6PP", "--show", "--real", "39").code == 2
    alone = gsp("maximize-real", "6PP", "--real", "0")
    assert alone.code == 2
    assert "--real 0 is for --show" in alone.err


def test_known_numbers_are_a_column_and_a_key(gsp) -> None:
    row = gsp("enumerate", "--only", "PP", "--columns", "id,real_counts", "--format", "csv").out
    assert row.splitlines()[1] == "DPP DPP DPP DPP DPP DPP,0..40"
    document = json.loads(gsp("bound", "6PP", "--format", "json").out)
    assert document["real_counts"] == list(range(0, 41, 2))


def test_a_second_search_on_the_same_state_is_refused(gsp, tmp_path):
    from gspcli.journal import held

    path = tmp_path / "state.json"
    words = ["maximize-real", "3D3A", "PH", "PH", "PH", "--attempts", "1", "--resume", path]
    with held(path):
        run = gsp(*words)
    assert run.code == 2
    assert run.err == f"error: {path}: another process is at this work: wait, or use another file\n"
    assert gsp(*words).code == 0
    assert [one.name for one in tmp_path.iterdir()] == ["state.json"]
