"""MJCF: ignored elements, refused files, and models that gsp wrote."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import machine_models as models
import numpy as np
import pytest

import gspcli
from gspcli.errors import GspError, SpecError
from gspcli.machines.api import import_machine
from gspcli.machines.graph import NoPlatform


@pytest.fixture
def read(tmp_path: Path):
    def imported(text: str, **options: object):
        path = tmp_path / "robot.xml"
        path.write_text(text, encoding="utf-8")
        return import_machine(path, **options)

    return imported


def without_text(model: str) -> str:
    return re.sub(r"<custom>.*?</custom>", "", model, flags=re.DOTALL)


@pytest.mark.parametrize("name", ["rubin-m2", "nano-hexapod", "figure-4", "fixture-3-2-1"])
def test_a_model_of_gsp_leads_back_exactly(read, name: str) -> None:
    instance = gspcli.example(name)
    found = read(str(gspcli.exported(instance, "mjcf")))
    assert found.instance == instance
    assert gspcli.loads(found.text) == instance


def test_a_changed_model_is_read_itself(read) -> None:
    model = str(gspcli.exported(gspcli.example("nano-hexapod"), "mjcf"))
    moved = re.sub(r'(<body name="chain_1_1" pos=")\S+', r"\g<1>0.25", model)
    assert moved != model
    found = read(moved)
    assert any("changed after gsp wrote it" in note for note in found.notes)
    assert found.instance.constraints[0].base.point[0] == 0.25
    # Other blanks and comments are no change.
    again = read(model.replace("\n", "\n\n").replace("</worldbody>", "<!-- mine --></worldbody>"))
    assert again.instance == gspcli.example("nano-hexapod")


@pytest.mark.parametrize(
    "name",
    ["dietmaier", "figure-2", "figure-3", "figure-4", "example-6.8", "fixture-3-2-1", "six-planes",
     "octahedral-3-3", "rubin-camera"],
)  # fmt: skip
def test_the_joints_of_a_model_of_gsp_have_its_modes(read, name: str) -> None:
    instance = gspcli.example(name)
    found = read(without_text(str(gspcli.exported(instance, "mjcf"))))
    before, after = gspcli.solve(instance), gspcli.solve(found.instance)
    metre = {"m": 1.0, "mm": 1e-3}.get(instance.units.length, 1.0)
    poses = np.concatenate(
        (before.R[before.real].real.reshape(-1, 9), metre * before.T[before.real].real), axis=1
    )
    own = np.concatenate(
        (after.R[after.real].real.reshape(-1, 9), after.T[after.real].real), axis=1
    )
    apart = np.abs(poses[:, None] - own[None]).max(axis=2)
    # Each mode of the import is one of the original, and no two are the same one.
    assert (apart.min(axis=0) < 1e-6).all()
    assert len(set(apart.argmin(axis=0).tolist())) == len(own)
    two_sided = any(row.kind.has_sides and row.side.value == "both" for row in instance.constraints)
    assert len(own) == len(poses) or two_sided


def test_bodies_of_which_a_motor_is_a_stage_below(read) -> None:
    reachy = models.public("reachy_mini.xml")
    found = import_machine(reachy)
    shipped = gspcli.example("reachy-mini-head")
    assert found.platform == "xl_330"
    ends = np.array([row.platform.point for row in found.instance.constraints])
    expected = np.array([row.platform.point for row in shipped.constraints])
    distances = [np.linalg.norm(x[:, None] - x[None], axis=2) for x in (ends, expected)]
    assert np.abs(distances[0] - distances[1]).max() < 4e-9
    for row, own in zip(shipped.constraints, found.instance.constraints, strict=True):
        arms = []
        for point in (row.base, own.base):
            arm = point.point - np.array([x.value for x in point.crank.centre])
            axis = np.array([x.value for x in point.crank.axis])
            arms.append(np.linalg.norm(np.cross(arm, axis / np.linalg.norm(axis))))
        assert arms[0] == pytest.approx(arms[1], abs=1e-8)
        assert own.value.value == pytest.approx(0.085, abs=2e-8)
    assert gspcli.solve(found.instance).counts.real == 8


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ('<include file="/etc/passwd"/>', "found <include>, expected one file"),
        ('<replicate count="9999999"><geom size="1"/></replicate>', "found <replicate>"),
        ('<composite type="grid" count="9999 9999 1"/>', "found <composite>"),
    ],
)
def test_what_leads_elsewhere_is_refused_at_its_place(read, what: str, says: str) -> None:
    with pytest.raises(SpecError, match=says) as error:
        read(models.rps().replace("<worldbody>", f"<worldbody>\n  {what}"))
    assert "robot.xml:2:3" in str(error.value)


def test_meshes_are_not_opened(read) -> None:
    text = models.rps().replace(
        "<worldbody>",
        '<asset><mesh name="seen" file="/nowhere/seen.stl"/></asset><worldbody>'
        '<geom type="mesh" mesh="seen"/>',
    )
    found = read(text.replace('<geom size=".1"/>', '<geom type="mesh" mesh="seen"/>'))
    assert found.instance.dynamics is None
    assert found.instance.constraints == read(models.rps()).instance.constraints


def test_entities_are_refused(read) -> None:
    bomb = '<!DOCTYPE mujoco [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>' + models.rps()
    with pytest.raises(SpecError, match="entities are not read"):
        read(bomb)
    outside = '<!DOCTYPE mujoco SYSTEM "file:///etc/passwd">' + models.rps()
    assert read(outside).instance == read(models.rps()).instance


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected"),
        ("hello", "found 'hello'"),
        ("<mujoco>", "no well-formed XML: no element found"),
        ("<mujoco><a></mujoco>", "mismatched tag"),
        ("<mujoco/>", "none"),
        ("<mujoco><worldbody><body/></worldbody><nonsense/></mujoco>", "cannot compile"),
        ("<a>" * 200 + "</a>" * 200, "100 levels deep"),
    ],
)
def test_wrong_files(read, text: str, says: str) -> None:
    with pytest.raises(GspError, match=re.escape(says)):
        read(text)


def test_gears_and_tendons_are_refused(read) -> None:
    text = models.rps()
    geared = text.replace("</equality>", '<joint joint1="s0" joint2="s1"/></equality>')
    with pytest.raises(NoPlatform, match="'s0' and 's1' geared"):
        read(geared)
    tendon = '<tendon><fixed name="t"><joint joint="s0" coef="1"/></fixed></tendon><actuator>'
    pulled = text.replace("<actuator>", tendon).replace(
        '<motor joint="s0"/>', '<motor name="pull" tendon="t"/>'
    )
    with pytest.raises(NoPlatform, match="'pull' on a tendon"):
        read(pulled)


def test_without_mujoco_only_models_of_gsp_are_read(read, monkeypatch) -> None:
    instance = gspcli.example("figure-4")
    model = str(gspcli.exported(instance, "mjcf"))
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert read(model).instance == instance
    with pytest.raises(GspError, match=r"pip install 'gspcli\[simulation\]'"):
        read(models.rps())
