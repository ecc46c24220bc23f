"""MJCF: what the actuators can be told, and what they move."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

import gspcli
from tests.support.driven_machines import driven


def _ranges(text: str) -> np.ndarray:
    actuators = ET.fromstring(text).findall("actuator/general")
    return np.array([[float(x) for x in each.get("ctrlrange").split()] for each in actuators])


def test_the_control_of_a_crank_has_the_range_of_its_joint() -> None:
    text = str(gspcli.exported(driven("reachy-mini-head"), "mjcf"))
    joints = [j.get("range") for j in ET.fromstring(text).iter("joint") if j.get("range")]
    assert np.array_equal(_ranges(text), [[float(x) for x in each.split()] for each in joints])
    assert np.allclose(np.degrees(_ranges(text)[0]), [-83.9, 44.1])


def test_the_control_of_a_leg_is_a_change_within_its_range() -> None:
    """Legs of 320 to 520 mm."""
    instance = gspcli.example("workspace-study")
    ranges = _ranges(str(gspcli.exported(instance, "mjcf")))
    lengths = [row.value.value / 1000 for row in instance.constraints]
    assert np.allclose(ranges + np.transpose([lengths]), [0.32, 0.52], rtol=0, atol=1e-12)


def test_without_a_range_or_with_one_of_one_number_controls_are_free() -> None:
    """MuJoCo refuses a range of one number."""
    text = gspcli.dumps(gspcli.example("workspace-study"))
    for given in ("", ", range: [320, 320]"):
        instance = gspcli.loads(text.replace(", range: [320, 520]", given))
        assert "ctrlrange" not in str(gspcli.exported(instance, "mjcf"))


@pytest.mark.parametrize("name", ["reachy-mini-head", "workspace-study"])
def test_controls_move_what_no_equality_holds(name: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    text = str(gspcli.exported(driven(name), "mjcf"))
    low, high = _ranges(text).T
    for free in (False, True):
        model = mujoco.MjModel.from_xml_string(
            text.replace('name="hold_', 'active="false" name="hold_') if free else text
        )
        assert model.actuator_ctrllimited.all()
        data = mujoco.MjData(model)
        joints = model.jnt_qposadr[model.actuator_trnid[:, 0]]
        start = data.qpos[joints].copy()
        asked = np.where(high > -low, high, low) / 50
        data.ctrl = asked
        for _ in range(400):
            mujoco.mj_step(model, data)
        moved = data.qpos[joints] - start
        if free:
            assert np.allclose(moved, asked, rtol=0.05)
        else:
            assert np.abs(moved).max() < 1e-4 * np.abs(asked).max()
