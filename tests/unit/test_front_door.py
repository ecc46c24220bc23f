"""Files for services and archives: they agree with the package and with each other."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

import gspcli

ROOT = Path(gspcli.__file__).resolve().parents[1]


def read(name: str) -> Any:
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))


def test_the_action_is_that_of_its_page() -> None:
    action, page = read("action.yml"), (ROOT / "docs/action.md").read_text(encoding="utf-8")
    assert action["runs"]["using"] == "composite"
    rows = re.findall(r"^\| `([\w-]+)` \| .* \| `(.+?)` \|$", page, re.MULTILINE)
    assert dict(rows) == {name: one["default"] for name, one in action["inputs"].items()}
    workflow = re.search(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert workflow is not None
    (step,) = (
        one for one in yaml.safe_load(workflow[1])["jobs"]["check"]["steps"] if "with" in one
    )
    assert set(step["with"]) <= set(action["inputs"])


@pytest.mark.parametrize(
    ("files", "code"), [("good/**/*.yaml", 0), ("*/*.yaml", 2), ("none/*.yaml", 2)]
)
def test_the_action_checks_files(files: str, code: int, tmp_path: Path) -> None:
    """Its last step, run by the shell: right files, a wrong one, none."""
    for name in ("good/one.yaml", "good/deep/two.yaml", "bad/three.yaml"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        text = gspcli.dumps(gspcli.example("rubin-m2"))
        path.write_text(text.replace("value:", "valeu:") if "bad" in name else text, "utf-8")
    step = read("action.yml")["runs"]["steps"][-1]
    script = step["run"].replace('gsp check "${found[@]}"', '"$GSP" check "${found[@]}"')
    environment = {
        "FILES": files,
        "GSP": str(ROOT / ".venv/bin/gsp"),
        "PATH": "/usr/bin:/bin",
    }
    if not Path(environment["GSP"]).exists():
        pytest.skip("the program is not in .venv")
    run = subprocess.run(
        ["bash", "-e", "-c", script],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == code, run.stderr
    if files.startswith("*"):
        assert "bad/three.yaml:" in run.stderr


def test_check_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    from gspcli.cli.main import run

    assert run(["check", "--schema"]) == 0
    recorded = (ROOT / "data" / "instance.schema.json").read_text(encoding="utf-8")
    assert capsys.readouterr().out.rstrip() == recorded.rstrip()
    assert run(["check"]) == 2
    assert run(["check", "--schema", "@dietmaier"]) == 2
