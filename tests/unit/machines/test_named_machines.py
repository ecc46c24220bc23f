"""Machines of lower mobility: their counts, and the constraints that models of them give."""

from __future__ import annotations

from pathlib import Path

import machine_models as models
import numpy as np
import pytest

import gspcli
from gspcli.machines.api import import_machine


@pytest.mark.parametrize(
    ("name", "count", "kinds"),
    [
        # Kim and Park 2001: a polynomial of degree 16 for chains of a hinge and a ball.
        ("three-rps", 16, "3DPP 3DPH"),
        ("three-prs", 16, "3DPP 3DPH"),
        ("tricept", 24, "3DPP 2DHP ALL"),
        ("delta", 28, "6DPP"),
        ("hexaglide", 36, "6DPP"),
    ],
)
def test_counts(name: str, count: int, kinds: str) -> None:
    from gspcli.cli.commands.example import short_name

    instance = gspcli.example(name)
    result = gspcli.solve(instance)
    assert short_name(instance.type) == kinds
    assert result.verdict == "complete"
    assert len(result.R) == count


def test_a_delta_robot_that_does_not_turn_is_where_three_spheres_meet() -> None:
    instance = gspcli.example("delta")
    result = gspcli.solve(instance)
    R, T = result.R[result.real].real, result.T[result.real].real
    still = np.abs(R - np.eye(3)).max(axis=(1, 2)) < 1e-9
    across = 524 + 567 * np.sqrt(3) / 6 - 76 * np.sqrt(3) / 3
    height = np.sqrt(1244**2 - across**2)
    assert still.sum() == 2
    assert np.allclose(sorted(T[still, 2]), [-height, height])
    assert height == pytest.approx(1064.45, abs=0.01)


def tricept() -> str:
    """Return a model: legs with balls at both ends, and a passive leg that guides the platform."""
    bodies = closures = actuators = ""
    bodies += (
        '<body name="fork"><joint type="hinge" axis="1 0 0"/><joint type="hinge" axis="0 1 0"/>'
        '<geom size=".1"/><body name="table" pos="0 0 8"><joint type="slide" axis="0 0 1"/>'
        '<geom size=".1"/></body></body>'
    )
    for i in range(3):
        t = 2 * np.pi * i / 3
        b = np.array([5 * np.cos(t), 5 * np.sin(t), 0])
        p = np.array([2 * np.cos(t), 2 * np.sin(t), 8])
        e = (p - b) / np.linalg.norm(p - b)
        bodies += (
            f'<body name="leg{i}" pos="{models.row(b)}"><joint type="ball"/><geom size=".1"/>'
            f'<body name="rod{i}"><joint name="jack{i}" type="slide" axis="{models.row(e)}"/>'
            '<geom size=".1"/></body></body>'
        )
        anchor = models.row(p - [0, 0, 8])
        closures += f'<connect body1="table" body2="rod{i}" anchor="{anchor}"/>'
        actuators += f'<motor joint="jack{i}"/>'
    return (
        f'<mujoco><compiler angle="radian"/><worldbody>{bodies}</worldbody>'
        f"<equality>{closures}</equality><actuator>{actuators}</actuator></mujoco>"
    )


def test_a_model_of_a_tricept_has_its_modes(tmp_path: Path) -> None:
    path = tmp_path / "tricept.xml"
    path.write_text(tricept(), encoding="utf-8")
    found = import_machine(path, digits=17)
    assert sorted(row.kind.name for row in found.instance.constraints) == sorted(
        row.kind.name for row in gspcli.example("tricept").constraints
    )
    poses = []
    for instance in (found.instance, gspcli.example("tricept")):
        result = gspcli.solve(instance)
        R, T = result.R[result.real].real, result.T[result.real].real
        poses.append(np.concatenate((R.reshape(-1, 9), T), axis=1))
    apart = np.abs(poses[0][:, None] - poses[1][None]).max(axis=2)
    assert apart.shape == (8, 8)
    assert apart.min(axis=0).max() < 1e-8
    assert apart.min(axis=1).max() < 1e-8


def test_models_of_tripods_have_their_modes(tmp_path: Path) -> None:
    path = tmp_path / "tripod.xml"
    path.write_text(models.rps(), encoding="utf-8")
    found = import_machine(path)
    assert len(gspcli.solve(found.instance).R) == 16
