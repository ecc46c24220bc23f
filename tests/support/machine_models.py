"""Models of machines as other programs have them, made here, and where the public files are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
#: Public files, which are not part of the project: beside the checkout, where there are any.
PUBLIC = ROOT.parent / "shared" / "machine-files"
if not PUBLIC.is_dir():
    PUBLIC = ROOT.parents[1] / "shared" / "machine-files"


def public(name: str) -> Path:
    """Return a public file; the test is skipped where it is not there."""
    path = PUBLIC / name
    if not path.exists():
        pytest.skip(f"{name} is not here")
    return path


def row(numbers: object) -> str:
    """Return numbers as attributes have them."""
    return " ".join(repr(float(x)) for x in np.ravel(np.asarray(numbers, float)))


def mjcf(bodies: str, closures: str, actuators: str, platform: str) -> str:
    """Return a model: bodies at the world, the platform, closures and actuators."""
    return (
        f'<mujoco model="made"><compiler angle="radian"/><worldbody>{bodies}'
        f'<body name="platform" pos="{platform}"><freejoint/><geom size=".1"/></body></worldbody>'
        f"<equality>{closures}</equality><actuator>{actuators}</actuator></mujoco>"
    )


def rps(count: int = 3, *, gap: float = 0.0) -> str:
    """Return as many chains hinge, driven slide, ball; the balls are open by a gap."""
    bodies = closures = actuators = sites = ""
    for i in range(count):
        t = 2 * np.pi * i / count
        b, p = np.array([np.cos(t), np.sin(t), 0]), np.array([0.6 * np.cos(t), 0.6 * np.sin(t), 1])
        e = (p - b) / np.linalg.norm(p - b)
        bodies += (
            f'<body name="c{i}" pos="{row(b)}"><joint name="r{i}" type="hinge" '
            f'axis="{row([-np.sin(t), np.cos(t), 0])}"/><geom size=".02"/><body name="rod{i}">'
            f'<joint name="s{i}" type="slide" axis="{row(e)}" range="-.3 .3" limited="true"/>'
            f'<geom size=".02"/><site name="q{i}" pos="{row(p - b)}"/></body></body>'
        )
        sites += f'<site name="p{i}" pos="{row(p - [0, 0, 1 + gap])}"/>'
        closures += f'<connect site1="p{i}" site2="q{i}"/>'
        actuators += f'<motor joint="s{i}"/>'
    closed = mjcf(bodies, closures, actuators, "0 0 1")
    return closed.replace("<freejoint/>", f"<freejoint/>{sites}")


def legs(letters: Sequence[str], *, offset: float = 0.0, seed: int = 3) -> str:
    """Return legs of hinges, a driven slide and hinges or a ball.

    Parameters
    ----------
    letters
        For each leg UPS, UPU or UPRU (a hinge along the leg, then a universal joint).
    offset
        How far the two axes of the universal joint at the base pass each other.
    """
    bodies = closures = actuators = ""
    rng = np.random.default_rng(seed)
    for i, leg in enumerate(letters):
        b = np.append(rng.normal(size=2), 0)
        p = np.append(rng.normal(size=2) * 0.6, 1)
        e = (p - b) / np.linalg.norm(p - b)
        u = np.cross(e, [0, 0, 1]) / np.linalg.norm(np.cross(e, [0, 0, 1]))
        w = np.cross(e, u)
        spin = f'<joint type="hinge" axis="{row(e)}"/>' if "R" in leg else ""
        end = f'<joint type="hinge" axis="{row(w)}"/><joint type="hinge" axis="{row(u)}"/>'
        if leg.endswith("S"):
            end = '<joint type="ball"/>'
        bodies += (
            f'<body name="c{i}" pos="{row(b)}"><joint type="hinge" axis="{row(u)}"/>'
            f'<joint type="hinge" axis="{row(w)}" pos="{row(offset * e)}"/><geom size=".02"/>'
            f'<body name="rod{i}"><joint name="s{i}" type="slide" axis="{row(e)}"/>'
            f'<geom size=".02"/><body name="x{i}" pos="{row(p - b)}">{spin}{end}'
            '<geom size=".02"/></body></body></body>'
        )
        closures += f'<weld body1="platform" body2="x{i}"/>'
        actuators += f'<motor joint="s{i}"/>'
    return mjcf(bodies, closures, actuators, "0 0 1")


def rotary(seed: int = 5) -> str:
    """Return six driven arms with rods on balls."""
    bodies = closures = actuators = ""
    rng = np.random.default_rng(seed)
    for i in range(6):
        t = np.pi * i / 3 + 0.2 * (-1) ** i
        centre = np.array([np.cos(t), np.sin(t), 0.0])
        axis = np.array([-np.sin(t), np.cos(t), 0.1 * rng.normal()])
        arm = 0.3 * np.array([np.cos(t), np.sin(t), 0.0])
        p = np.array([0.6 * np.cos(t + 0.3), 0.6 * np.sin(t + 0.3), 1.0])
        bodies += (
            f'<body name="arm{i}" pos="{row(centre)}"><joint name="m{i}" type="hinge" '
            f'axis="{row(axis)}" range="-1 1" limited="true"/><geom size=".02"/>'
            f'<body name="rod{i}" pos="{row(arm)}"><joint type="ball"/><geom size=".02"/>'
            "</body></body>"
        )
        anchor = row(p - [0, 0, 1])
        closures += f'<connect body1="platform" body2="rod{i}" anchor="{anchor}"/>'
        actuators += f'<position joint="m{i}"/>'
    return mjcf(bodies, closures, actuators, "0 0 1")
