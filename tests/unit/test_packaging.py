"""The wheel holds the kernel and the data, and works without the checkout.

The kernel in it is the installed one: that its sources compile is seen by `make install`, and in
the wheels for other machines by `tools/wheel.py`.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import gspcli._kernel

ROOT = Path(__file__).resolve().parents[2]
#: Stands for the CMakeLists.txt of the checkout, with the same rule of installation.
KERNEL = """
cmake_minimum_required(VERSION 3.24)
project(gspcli LANGUAGES NONE)
install(FILES "{kernel}" DESTINATION gspcli)
"""
CHECK = """
import gspcli, pathlib, sys
from gspcli.cli.main import run
from gspcli.resources import data_directory
home = pathlib.Path(sys.argv[1]).resolve()
assert home in pathlib.Path(gspcli.__file__).resolve().parents, gspcli.__file__
assert home in data_directory().parents, data_directory()
examples = data_directory() / "examples"
sys.exit(run(["solve", str(examples / "example-6.8.yaml")])
         or run(["solve", str(examples / "dietmaier.yaml")])
         or run(["table", "3"]))
"""


def test_an_installed_wheel_is_complete(tmp_path: Path) -> None:
    wheels, home = tmp_path / "wheels", tmp_path / "home"
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    build = [*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(wheels)]
    kernel = tmp_path / "kernel"
    kernel.mkdir()
    (kernel / "CMakeLists.txt").write_text(KERNEL.format(kernel=gspcli._kernel.__file__))
    environment = {
        **os.environ,
        "SKBUILD_BUILD_DIR": str(tmp_path / "build"),
        "SKBUILD_CMAKE_SOURCE_DIR": str(kernel),
    }
    subprocess.run([*build, str(ROOT)], check=True, env=environment)
    (wheel,) = wheels.iterdir()
    data = [x for x in zipfile.ZipFile(wheel).namelist() if x.startswith("gspcli/data/")]
    made_of = [x for x in data if x.endswith("manifest.json")]
    assert made_of == ["gspcli/data/start-systems/manifest.json"]
    assert not any("trajectories" in x for x in data)
    subprocess.run([*pip, "install", "--no-deps", "--target", str(home), str(wheel)], check=True)
    # -S leaves the editable installation out; the dependencies are put back by hand.
    dependencies = [path for path in sys.path if path.endswith("site-packages")]
    run = subprocess.run(
        [sys.executable, "-S", "-c", CHECK, str(home)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(home), *dependencies])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert "complete, proved: all 64 of the type" in run.stdout
    assert "complete, proved: all 40 of the type" in run.stdout


def test_wheels_are_checked_for_the_versions_that_are_promised() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    page = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    found = re.search(r"Python 3\.(\d+) to 3\.(\d+) on Linux", page)
    assert found is not None
    first, last = map(int, found.groups())
    builds = project["tool"]["cibuildwheel"]["build"]
    assert builds == [f"cp3{minor}-*" for minor in range(first, last + 1)]
    assert project["project"]["requires-python"] == f">=3.{first}"
    assert project["tool"]["scikit-build"]["wheel"]["py-api"] in {b.rstrip("-*") for b in builds}
