"""The example for LinuxCNC, built, loaded and run in LinuxCNC itself (Debian: linuxcnc-uspace-dev).

Without it these tests are left out, but not in CI. A module can be loaded only from LinuxCNC's own
folder: it is put there, and taken away again. Only one LinuxCNC runs on a machine at a time.
"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

import gspcli
from gspcli.resources import instance_files
from tests.support.controllers import linuxcnc

SUPPORT = Path(__file__).parents[1] / "support" / "linuxcnc"
EXAMPLES = Path(__file__).parents[2] / "docs" / "controller"
MODULES = Path("/usr/lib/linuxcnc/modules")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder of a module of @linuxcnc-hexapod; what happens in LinuxCNC happens to one test."""
    if not all(map(shutil.which, ("linuxcnc", "halcompile", "halrun"))):
        if os.environ.get("CI_NEEDS_LINUXCNC"):
            pytest.fail("no LinuxCNC on this machine, and CI_NEEDS_LINUXCNC is set")
        pytest.skip("no LinuxCNC on this machine (Debian: apt-get install linuxcnc-uspace-dev)")
    if not os.access(MODULES, os.W_OK):
        pytest.skip(f"modules cannot be installed in {MODULES}")
    folder = tmp_path_factory.mktemp("module")
    lock = Path(tempfile.gettempdir()) / "gsp-test-linuxcnc.lock"
    with lock.open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        module = linuxcnc.build_module(*machine("linuxcnc-hexapod"), folder)
        target = MODULES / module.name
        shutil.copy(module, target)
        yield folder
        target.unlink()


def machine(name):
    instance = gspcli.load(instance_files()[name])
    result = gspcli.solve(instance)
    return instance, result.real_solutions[result.home.number - 1]


def run(*command, cwd):
    """Run a program of LinuxCNC; root needs another user for the part that is real-time."""
    home = Path(tempfile.mkdtemp())
    home.chmod(0o777)
    env = os.environ | {"HOME": str(home), "RUNTESTS": "1", "RTAPI_UID": "65534"}
    env["RTAPI_FIFO_PATH"] = str(home / "fifo")
    env.pop("DISPLAY", None)
    done = subprocess.run(
        command,
        cwd=cwd,
        env=env,
        check=False,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
    )
    shutil.rmtree(home)
    return done.stdout


def test_the_module_is_loaded_with_its_pins(installed, tmp_path):
    (tmp_path / "load.hal").write_text(
        "loadrt provedkins\nloadrt tpmod\nloadrt homemod\n"
        "loadrt motmod servo_period_nsec=1000000 num_joints=6\n"
        f"source {EXAMPLES / 'provedkins.hal'}\n"
        "show pin provedkins\nshow funct provedkins\nshow sig pose-proved\n"
    )
    said = run("halrun", "-f", "load.hal", cwd=tmp_path)
    assert "undefined symbol" not in said
    lines = [line.split() for line in said.splitlines()]
    pins = {words[4]: words[1:4] for words in lines if len(words) > 4 and words[1:2] != ["RT"]}
    assert pins["provedkins.homed"] == ["bit", "IN", "FALSE"]
    assert pins["provedkins.proved"] == ["bit", "OUT", "TRUE"]
    assert pins["provedkins.refusals"] == ["u32", "OUT", "0x00000000"]
    assert pins["provedkins.status"] == ["s32", "OUT", "0"]
    assert ["==>", "motion.enable"] in lines


def operate(tmp_path, halfile):
    """Let the operator work; return what is said after each action, and the sampler's rows."""
    for name in ("sim.hal", "sim.py", "homed.hal"):
        shutil.copy(SUPPORT / name, tmp_path)
    shutil.copy(EXAMPLES / "provedkins.hal", tmp_path)
    ini = (SUPPORT / "sim.ini").read_text().replace("@HALFILE@", halfile)
    (tmp_path / "sim.ini").write_text(ini)
    (tmp_path / "sim.tbl").write_text("")
    said = run("linuxcnc", "sim.ini", cwd=tmp_path)
    lines = [json.loads(x[5:]) for x in said.splitlines() if x.startswith("JSON ")]
    assert lines, said
    rows = [line["rows"] for line in lines if "rows" in line]
    return {line["after"]: line for line in lines if "after" in line}, rows[0]


def test_linuxcnc_goes_on_where_the_pose_is_refused(installed, tmp_path):
    # The statement of docs/controller.md about LinuxCNC without the pin connected.
    after, _ = operate(tmp_path, "homed.hal")
    assert after["home"]["on"]
    assert after["home"]["homed"]
    assert after["home"]["refusals"] == 0
    lost = after["lost"]
    assert not lost["proved"]
    assert lost["refusals"] > 100
    assert lost["on"]
    assert lost["moving"]
    assert lost["messages"] == []
    # What is shown is the home of [TRAJ], and it goes on to where it was sent.
    assert np.allclose(lost["shown"], [0, 0, 20])
    assert lost["asked"][0] > after["move"]["asked"][0] + 0.05


def test_the_pin_switches_the_machine_off_and_homing_helps(installed, tmp_path):
    after, rows = operate(tmp_path, "provedkins.hal")
    for what in ("on", "home", "move"):
        assert after[what]["on"]
        assert after[what]["proved"]
        assert after[what]["refusals"] == 0
    assert after["move"]["moving"]
    lost = after["lost"]
    assert not lost["proved"]
    assert not lost["on"]
    assert not lost["moving"]
    assert "motion stopped by enable input" in lost["messages"]
    # Motion is disabled in the servo period of the refusal.
    assert any(row.split() == ["1", "1"] for row in rows)
    assert any(row.split() == ["0", "0"] for row in rows)
    assert not any(row.split() == ["0", "1"] for row in rows)
    # It cannot be switched on before it is homed again.
    assert not after["on again"]["on"]
    assert any("enable input is false" in text for text in after["on again"]["messages"])
    assert after["unhome"]["proved"]
    again = after["home again"]
    assert again["on"]
    assert again["homed"]
    assert again["proved"]
    assert after["move again"]["asked"][0] > again["asked"][0] + 0.01
    assert after["move again"]["proved"]


@pytest.mark.parametrize("name", ["linuxcnc-hexapod", "reachy-mini-head"])
def test_worlds_go_to_joints_and_back(installed, name):
    row = linuxcnc.examine(2000, name)
    assert row.compared > 1000
    assert row.difference <= 1e-11
