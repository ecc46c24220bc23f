"""Files for services and archives: they agree with the package and with each other."""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

import gspcli

ROOT = Path(gspcli.__file__).resolve().parents[1]


def read(name: str) -> Any:
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def citation() -> Any:
    return read("CITATION.cff")


@pytest.fixture(scope="module")
def project() -> Any:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_zenodo_says_what_the_citation_says(citation: Any) -> None:
    found = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    assert found["title"] == citation["title"]
    assert found["version"] == citation["version"] == gspcli.__version__
    assert found["license"] == citation["license"]
    assert found["publication_date"] == citation["date-released"]
    assert found["keywords"] == citation["keywords"]
    assert found["creators"] == [{"name": one["name"]} for one in citation["authors"]]
    assert found["description"] == citation["abstract"]


def test_the_paper_has_the_authors_and_cites_what_it_lists(citation: Any) -> None:
    text = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
    _, head, body = text.split("---\n", 2)
    meta = yaml.safe_load(head)
    assert meta["title"] == citation["title"]
    assert [one["name"] for one in meta["authors"]] == [one["name"] for one in citation["authors"]]
    assert (ROOT / "paper" / meta["bibliography"]).exists()
    entries = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper/paper.bib").read_text("utf-8"), re.M)
    assert set(re.findall(r"@(\w+\d{4})", body)) == set(entries)
    # What the journal asks for.
    assert "# Summary" in body
    assert "# Statement of need" in body
    assert 250 <= len(body.split()) <= 1000


def test_the_conda_recipe_has_the_requirements(project: Any) -> None:
    recipe = read("conda/recipe.yaml")
    assert recipe["context"]["version"] == gspcli.__version__
    assert recipe["package"]["name"] == project["name"]
    run = {"".join(one.split()) for one in recipe["requirements"]["run"]}
    assert run == {*project["dependencies"], "python" + project["requires-python"]}
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    system = tomllib.loads(text)["build-system"]["requires"]
    host = {"".join(one.split()) for one in recipe["requirements"]["host"]}
    assert host == {*system, "python", "pip"}
    # The compilers as conda-forge names them; without them the recipe cannot be rendered.
    assert set(read("conda/variants.yaml")) == {"c_stdlib", "c_stdlib_version"}
    name, entry = recipe["build"]["python"]["entry_points"][0].split(" = ")
    assert {name: entry} == project["scripts"]


def test_the_site_is_built_from_its_configuration() -> None:
    found = read(".readthedocs.yaml")
    assert found["version"] == 2
    assert (ROOT / found["sphinx"]["configuration"]).exists()
    assert "--group docs" in found["build"]["jobs"]["install"][0]


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


def test_continuous_integration_has_the_versions_of_wheels() -> None:
    """The first supported version and those that wheels are checked with."""
    jobs = read(".github/workflows/ci.yml")["jobs"]
    versions = set(jobs["versions"]["strategy"]["matrix"]["python"])
    first = jobs["checks"]["container"].removeprefix("python:").partition("-")[0]
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    built = re.findall(r'"cp3(\d+)-\*"', text)
    assert {first, *versions} == {f"3.{minor}" for minor in built}


def test_check_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    from gspcli.cli.main import run

    assert run(["check", "--schema"]) == 0
    recorded = (ROOT / "data" / "instance.schema.json").read_text(encoding="utf-8")
    assert capsys.readouterr().out.rstrip() == recorded.rstrip()
    assert run(["check"]) == 2
    assert run(["check", "--schema", "@dietmaier"]) == 2
