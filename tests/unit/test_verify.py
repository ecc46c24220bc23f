"""`make verify`: nothing is left out, and what is wrong or cannot be derived is not confirmed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def verify(load_tool: Callable) -> ModuleType:
    return load_tool("verify.__main__")


def test_every_file_of_the_data_is_derived_again_by_a_step(verify: ModuleType) -> None:
    patterns = {pattern for step in verify.STEPS for pattern in step.subject}
    found = {pattern: set(ROOT.glob(pattern)) for pattern in patterns}
    assert all(found.values()), found
    covered = set().union(*found.values())
    written_by_hand = set((ROOT / "data" / "keys").iterdir())
    files = {path for path in (ROOT / "data").rglob("*") if path.is_file()}
    assert files - written_by_hand <= covered


def test_every_step_is_a_program_that_compares(verify: ModuleType) -> None:
    for step in verify.STEPS:
        for fast in (False, True):
            words = step.words(fast=fast, jobs=2, work=Path("w"))
            assert {"--check", "check", "verify"} & set(words), step.name
            assert words[1] == "-m"
            assert find_spec(words[2]) is not None


ENDS = {
    "good": "print('details'); print('confirmed: 3 things')",
    "bad": "print('thing 2 is 5, recorded 4'); exit(1)",
    "unable": "import sys; print('no such program', file=sys.stderr); exit(4)",
    "broken": "raise RuntimeError",
}


@pytest.mark.parametrize(
    ("names", "code", "last"),
    [
        (["good"], 0, None),
        (["good", "unable"], 4, "not verified, for the reasons above: unable"),
        (["bad", "good"], 1, "different from the record, or failed: bad"),
        (["unable", "broken", "good"], 1, "different from the record, or failed: broken"),
    ],
)
def test_the_summary_and_the_exit_code(
    verify: ModuleType,
    names: list[str],
    code: int,
    last: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    for name in names:
        (tmp_path / f"{name}.py").write_text(ENDS[name])
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    monkeypatch.setenv("PYTHONPATH", path)
    steps = tuple(verify.Step(name, (), name) for name in names)
    monkeypatch.setattr(verify, "STEPS", steps)
    monkeypatch.setattr(verify, "WORK", tmp_path / "work")
    monkeypatch.setattr(sys, "argv", ["verify"])
    assert verify.main() == code
    printed = capfd.readouterr()
    rows = {line.split()[0]: line for line in printed.out.splitlines() if line}
    results = {
        "good": "confirmed",
        "bad": "DIFFERS",
        "unable": "NOT VERIFIED",
        "broken": "FAILED (1)",
    }
    assert all(results[name] in rows[name] for name in names)
    assert "confirmed" not in rows.get("unable", "")
    assert rows["good"].split()[-2:] == ["3", "things"]
    if last:
        assert printed.out.splitlines()[-1] == last
    assert ("thing 2 is 5, recorded 4" in printed.err) == ("bad" in names)
    # Work files are kept until everything is confirmed.
    assert any((tmp_path / "work").iterdir()) == (code != 0)


def test_unknown_steps_are_wrong_usage(
    verify: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["verify", "varietys"])
    with pytest.raises(SystemExit) as ended:
        verify.main()
    assert ended.value.code == 2
    assert "no such step: varietys; there are paper, constraints, varieties" in (
        capsys.readouterr().err
    )


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy of the programs and what they made, to be spoilt."""
    for folder in ("tools", "data", "docs"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    return tmp_path


def _replaced(old: str, new: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    return change


def _one_bit(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)


needs_singular = pytest.mark.skipif(
    shutil.which("Singular") is None, reason="Singular is not installed"
)


@pytest.mark.parametrize(
    ("command", "name", "change"),
    [
        pytest.param(
            "tools.build.varieties --check",
            "data/varieties.json",
            _replaced('"degree": 40', '"degree": 42'),
            marks=needs_singular,
        ),
        pytest.param(
            "tools.build.example_counts --check --groebner octahedral-3-3",
            "data/examples/expected.json",
            _replaced('"distinct": 16', '"distinct": 14'),
            marks=needs_singular,
        ),
        (
            "tools.build.example_counts --check octahedral-3-3",
            "data/examples/expected.json",
            _replaced('"distinct": 16', '"distinct": 14'),
        ),
        (
            "tools.build.coincident_counts --check",
            "data/verification/coincident-platforms.csv",
            _replaced(",40,40,", ",40,39,"),
        ),
        ("tools.build.start_systems --check --sample 1", "data/start-systems/points.npy", _one_bit),
        (
            "tools.witnesses check --sample 1",
            "data/witnesses/real.csv",
            _replaced("6D PP PP PP PP PP PP,40", "6D PP PP PP PP PP PP,42"),
        ),
        (
            "tools.witnesses.counts check --sample 1",
            "data/witnesses/counts.csv",
            _replaced(" 38:", " 39:"),
        ),
        (
            "tools.build.schema --check",
            "data/instance.schema.json",
            _replaced('"additionalProperties": false', '"additionalProperties": true'),
        ),
        ("tools.build.counts --docs --check", "docs/images/counts.svg", _replaced("<use", "<Use")),
        ("tools.build.pictures --check", "docs/images/enumerate.svg", _replaced("1120", "1220")),
    ],
    ids=lambda value: value.split()[0] if str(value).startswith("tools.") else "",
)
def test_what_is_spoilt_is_rejected(
    command: str, name: str, change: Callable[[Path], None], checkout: Path
) -> None:
    words = command.split()

    def check() -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", *words],
            capture_output=True,
            text=True,
            cwd=checkout,
        )

    confirmed = check()
    assert (confirmed.returncode, confirmed.stdout[:11]) == (0, "confirmed: "), confirmed.stderr
    change(checkout / name)
    rejected = check()
    assert rejected.returncode == 1, rejected.stderr
    assert any(part in rejected.stdout for part in Path(name).parts[1:])
    assert "confirmed" not in rejected.stdout


def test_a_witness_with_fewer_poses_is_wrong(load_tool: Callable) -> None:
    from dataclasses import replace

    tool, known = load_tool("witnesses.best"), load_tool("witnesses.known")
    found = next(w for w in known.recorded().values() if w.real < 20)
    assert tool.wrong(found) == ""
    assert f"{found.real} certified" in tool.wrong(replace(found, real=found.real + 2))


def test_records_are_compared_by_content(load_tool: Callable, tmp_path: Path) -> None:
    recording = load_tool("recording")
    path = tmp_path / "record.json"
    record = {"manifest": {"versions": {"python": "3.11"}, "seed": 1}, "counts": [1, 2]}
    other = {"counts": [1, 2], "manifest": {"seed": 1, "versions": {"python": "3.14"}}}
    wrong = {"counts": [1, 3], "manifest": {"seed": 1, "versions": {"python": "3.11"}}}
    assert recording.save({path: "{}"}, check=True, confirmed="") == recording.DIFFERENT
    assert recording.save({path: json.dumps(record)}, check=False, confirmed="") == 0
    assert recording.save({path: json.dumps(other)}, check=True, confirmed="") == 0
    assert recording.save({path: json.dumps(wrong)}, check=True, confirmed="") == 1
    assert json.loads(path.read_text()) == record


def test_samples_are_always_the_same_and_in_order(load_tool: Callable) -> None:
    recording = load_tool("recording")
    assert recording.sampled("abcdefgh", None) == list("abcdefgh")
    once = recording.sampled("abcdefgh", 3)
    assert once == recording.sampled("abcdefgh", 3) == sorted(once)
    assert recording.sampled("ab", 3) == ["a", "b"]
