"""SDF and URDF: what is written loads elsewhere, and comes back the same."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.export.mjcf import mjcf
from gspcli.geometry.primitives import Point, Slide
from gspcli.machines.api import import_machine
from tests.support import machine_files
from tests.support.driven_machines import driven

FORMS = {"mjcf": ".xml", "sdf": ".sdf", "urdf": ".urdf"}


@pytest.fixture
def written(tmp_path: Path):
    def write(name: str, form: str) -> Path:
        for suffix, text in gspcli.exported(gspcli.example(name), form).files.items():
            (tmp_path / f"model{suffix or FORMS[form]}").write_text(text, encoding="utf-8")
        return tmp_path / f"model{FORMS[form]}"

    return write


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["nano-hexapod", "figure-4", "fixture-3-2-1"])
def test_the_stored_instance_is_the_same(written, form: str, name: str) -> None:
    found = import_machine(written(name, form))
    assert found.instance == gspcli.example(name)
    assert found.format == "gsp"


@pytest.mark.parametrize("form", FORMS)
def test_a_changed_file_is_read_itself(written, form: str) -> None:
    path = written("nano-hexapod", form)
    text = path.read_text(encoding="utf-8")
    start = text.index("value_3")
    changed = text[:start] + text[start:].replace("0.0", "0.0001", 1)
    path.write_text(changed, encoding="utf-8")
    notes = " ".join(import_machine(path).notes)
    assert "changed after gsp wrote it" in notes


def test_changed_loops_are_a_change(written) -> None:
    path = written("nano-hexapod", "urdf")
    loops = path.with_suffix(".yaml")
    loops.write_text(loops.read_text(encoding="utf-8") + "# mine\n", encoding="utf-8")
    assert any("changed after gsp wrote it" in note for note in import_machine(path).notes)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["figure-3", "fixture-3-2-1", "surfaces-pcc"])
def test_the_joints_have_the_same_modes(written, form: str, name: str) -> None:
    instance = gspcli.example(name)
    found = import_machine(written(name, form), platform="platform", digits=17)
    before, after = machine_files.poses(instance)[0], machine_files.poses(found.instance)[0]
    wanted = machine_files.on_the_side(instance, found.instance, before)
    assert len(after)
    assert machine_files.compared(wanted, after) == (0, 0)
    # A pose that is another one is noticed.
    assert machine_files.compared(wanted, after + 1e-5)[0] == len(wanted)


def test_urdf_loads_elsewhere(written) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    mujoco = pytest.importorskip("mujoco")
    path = written("nano-hexapod", "urdf")
    model = pinocchio.buildModelFromUrdf(str(path))
    assert model.nv == 6 * 3 + 3
    assert mujoco.MjModel.from_xml_path(str(path)).njnt == 21
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    home = gspcli.solve(gspcli.example("nano-hexapod")).home
    platform = data.oMf[model.getFrameId("platform")]
    assert np.allclose(platform.translation, home.T, atol=1e-12)
    assert np.allclose(platform.rotation, home.R, atol=1e-12)
    for number in range(2, 7):
        ends = [data.oMf[model.getFrameId(f"{end}_{number}")] for end in ("end", "loop")]
        assert np.allclose(ends[0].translation, ends[1].translation, atol=1e-12)


def test_sdf_names_each_joint_once_and_closes_its_loops(written) -> None:
    text = written("rubin-m2", "sdf").read_text(encoding="utf-8")
    names = re.findall(r'<(?:joint|link) name="([^"]+)"', text)
    assert len(set(names)) == len(names)
    assert len(re.findall("<child>platform</child>", text)) == 6
    assert text.count("JointPositionController") == 6


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["reachy-mini-head", "t-top-head", "6-PUS", "delta"])
def test_arms_and_carriages_are_joints_and_lead_back_exactly(form, name, tmp_path) -> None:
    """The text that is stored leads back exactly; without it the joints say the same machine."""
    instance = driven(name)
    for suffix, text in gspcli.exported(instance, form).files.items():
        (tmp_path / f"m{suffix or FORMS[form]}").write_text(text, encoding="utf-8")
    path = tmp_path / f"m{FORMS[form]}"
    assert import_machine(path).instance == gspcli.loads(gspcli.dumps(instance))
    text = path.read_text(encoding="utf-8")
    assert '"drive_1"' in text
    stored = re.compile(r"<custom>.*?</custom>|<gsp:instance.*?</gsp:instance>", re.DOTALL)
    path.write_text(stored.sub("", text), encoding="utf-8")
    found = import_machine(path).instance
    for own, row in zip(found.constraints, instance.constraints, strict=True):
        assert own.kind is row.kind
        assert own.value.value == pytest.approx(row.value.value, abs=1e-9)
        assert own.base.point == pytest.approx(row.base.point, abs=1e-9)
        assert (own.base.crank is None) == (row.base.crank is None)


def test_a_drive_of_another_constraint_than_a_rod_is_refused() -> None:
    instance = gspcli.example("three-vee-18.5mm")
    rows = [
        replace(row, platform=Point(row.platform.point, slide=Slide([0, 0, 1])))
        if k == 0 and isinstance(row.platform, Point)
        else row
        for k, row in enumerate(instance.constraints)
    ]
    moved = replace(instance, constraints=tuple(rows))
    pose = gspcli.solve(instance).home
    with pytest.raises(ArgumentError, match="expected distances of two points"):
        mjcf(moved, pose.R.real, pose.T.real)
