"""`gsp export`."""

from __future__ import annotations

import re

import pytest

import gspcli
from gspcli.export.controller.writing import controller
from gspcli.export.formats import TRIES
from gspcli.resources import instance_files

# `gsp export --to c`: two files, and what is refused.


def test_writes_the_header_beside_the_source(gsp, tmp_path):
    source = tmp_path / "nano-hexapod.c"
    result = gsp("export", "@nano-hexapod", "--to", "c", "--mode", "8", "-o", str(source))
    assert (result.code, result.out) == (0, "")
    instance = gspcli.load(instance_files()["nano-hexapod"])
    home = gspcli.solve(instance).real_solutions[7]
    header, text = controller(instance, "nano_hexapod", name="nano-hexapod", home=home)
    assert (tmp_path / "nano-hexapod.h").read_text() == header
    assert source.read_text() == text
    assert "#define NANO_HEXAPOD_HOME {{0.0, 0.0, 0.09}, {1.0, 0.0, 0.0, 0.0}}\n" in header
    assert f"#define NANO_HEXAPOD_TRIES {TRIES}\n" in header


def test_prefix_tries_and_values(gsp, tmp_path):
    options = ["--prefix", "arm", "--tries", "9", "--set", "1=0.1", "-o", str(tmp_path / "x.c")]
    assert gsp("export", "@nano-hexapod", "--to", "c", *options).code == 0
    header = (tmp_path / "x.h").read_text()
    assert "#define ARM_TRIES 9\n" in header
    assert re.search(r"int arm_forward\(const double values\[6\], arm_state \*state", header)
    assert '#include "x.h"' in (tmp_path / "x.c").read_text()


def test_margin(gsp, tmp_path):
    for options, written in (([], "0.0"), (["--margin", "0.01"], "0.01")):
        path = tmp_path / "m2.c"
        assert gsp("export", "@rubin-m2", "--to", "c", *options, "-o", str(path)).code == 0
        assert f"#define M2_MARGIN {written} " in path.with_suffix(".h").read_text()
    result = gsp("export", "@rubin-m2", "--to", "c", "--margin", "2", "-o", str(tmp_path / "y.c"))
    assert result.code == 2
    assert "2.0 is not in the range 0<=x<=1" in result.err
    assert not (tmp_path / "y.c").exists()


def test_a_platform_without_a_real_pose_has_no_home(gsp, tmp_path):
    assert gsp("export", "@no-real-pose", "--to", "c", "-o", str(tmp_path / "x.c")).code == 0
    assert "X_HOME" not in (tmp_path / "x.h").read_text()
    result = gsp("export", "@no-real-pose", "--to", "c", "--mode", "1", "-o", str(tmp_path / "y.c"))
    assert result.code == 2
    assert "no real pose for its values" in result.err
    assert not (tmp_path / "y.c").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "two files are written: expected -o NAME.c"),
        (["-o", "program.txt"], "two files are written: expected -o NAME.c"),
        (["-o", "p.c", "--prefix", "1x"], "prefix: found '1x', expected a name in C"),
    ],
)
def test_what_is_refused(gsp, options, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = gsp("export", "@nano-hexapod", "--to", "c", *options)
    assert result.code == 2
    assert message in result.err
    assert not list(tmp_path.iterdir())


# `gsp export --to urdf`: two files, and what is refused.


def test_writes_the_loops_beside_the_robot(gsp, tmp_path) -> None:
    target = tmp_path / "nano.urdf"
    outcome = gsp("export", "@nano-hexapod", "--to", "urdf", "-o", str(target))
    assert (outcome.code, outcome.out) == (0, "")
    found = gspcli.exported(gspcli.example("nano-hexapod"), "urdf").files
    assert target.read_text() == found[".urdf"]
    assert target.with_suffix(".yaml").read_text() == found[".yaml"]
    # The loops are not written over by what is made of them.
    again = gsp("import", str(target), "-o", str(target.with_suffix(".yaml")))
    assert again.code == 2
    assert "it is no instance file" in again.err
    assert target.with_suffix(".yaml").read_text() == found[".yaml"]
    assert gsp("import", str(target), "-o", str(target)).code == 2


def test_needs_a_name_for_both(gsp, tmp_path) -> None:
    outcome = gsp("export", "@nano-hexapod", "--to", "urdf", "-o", str(tmp_path / "nano.xml"))
    assert outcome.code == 2
    assert "expected -o NAME.urdf, NAME.yaml is then beside it" in outcome.err
    assert not list(tmp_path.iterdir())
    assert gsp("export", "@nano-hexapod", "--to", "urdf").code == 2
