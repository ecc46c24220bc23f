"""The Dockerfile copies what a wheel needs, and its demo is that of `make demo`."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCKERFILE = (ROOT / "Dockerfile").read_text(encoding="utf-8")
#: Instructions with a line each, in order.
STEPS = [tuple(line.split(maxsplit=1)) for line in DOCKERFILE.splitlines() if line[:1].isupper()]


def _copied() -> list[str]:
    """Return what is copied from the checkout."""
    found = []
    for name, rest in STEPS:
        if name == "COPY" and not rest.startswith("--from"):
            found += rest.split()[:-1]
    return found


def _demo() -> list[list[str]]:
    """Return the words of each command that a container runs by default."""
    (command,) = (json.loads(rest) for name, rest in STEPS if name == "CMD")
    assert command[:2] == ["sh", "-c"]
    return [shlex.split(line) for line in command[2].split(" && ")]


def test_it_has_only_known_instructions() -> None:
    assert {name for name, _ in STEPS} == {"FROM", "RUN", "COPY", "WORKDIR", "CMD"}
    assert STEPS[0][0] == "FROM"


def test_it_copies_what_is_there_and_what_a_wheel_needs() -> None:
    copied = _copied()
    assert all((ROOT / name).exists() for name in copied)
    needed = {
        "pyproject.toml",
        "CMakeLists.txt",
        "README.md",
        "LICENSE",
        "native",
        "gspcli",
        "data",
    }
    assert needed <= set(copied)
    ignored = (ROOT / ".dockerignore").read_text(encoding="utf-8").split()
    assert not needed & set(ignored)


def test_its_demo_is_that_of_make() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8").partition("\ndemo:")[2]
    makefile = makefile.partition("\n\n")[0]
    theirs = re.findall(r"\$\(BIN\)/gsp (\S+)", makefile)
    assert [words[1] for words in _demo()] == theirs


@pytest.mark.slow
def test_its_commands_run_in_an_environment(tmp_path: Path) -> None:
    """As in the container, without its system: a wheel from what is copied, then the demo."""
    source, wheels, home = (tmp_path / name for name in ("src", "wheels", "env"))
    source.mkdir()
    for name in _copied():
        subprocess.run(["cp", "-r", ROOT / name, source], check=True)
    venv.create(home, with_pip=True)
    pip = [home / "bin" / "python", "-m", "pip"]
    build = [*pip, "wheel", "--quiet", "--no-deps", "--wheel-dir", wheels, source]
    subprocess.run(build, check=True)
    subprocess.run([*pip, "install", "--quiet", *wheels.glob("*.whl")], check=True)
    for words in _demo():
        program = [home / "bin" / "gsp", *words[1:]]
        done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, (words, done.stderr)
    assert (tmp_path / "example-6.8.html").is_file()
