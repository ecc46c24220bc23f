"""The real platforms: sources, home positions and ranges as their comments state them."""

import numpy as np
import pytest

from gspcli.geometry.measurement import Arrangement, residuals
from gspcli.resources import INSTANCE_FOLDERS, data_directory, instance_files
from gspcli.solver import solve
from gspcli.spec import load, read

NAMES = sorted(name for name, path in instance_files().items() if path.parent.name == "platforms")
#: Where the platform's origin is at home, the axes parallel; the comments of the files say so.
HOME = {
    "linuxcnc-hexapod": 20,
    "nano-hexapod": 0.09,
    "simscape-hexapod": 0.09,
    "simmechanics-hexapod": 2,
    "workspace-study": 400,
    "workspace-study-cones": 60,
    "t-top-head": 0.170294539,
    "reachy-mini-head": 0.177,
}
#: The sources of these state no home.
HOMELESS = ("linuxcnc-hexapod", "modified-paradex")
#: The source of these gives six decimals of the home position, or joints to a nanometre.
ROUNDED = {"t-top-head": 1e-8, "reachy-mini-head": 2e-9}


def test_no_name_is_used_twice():
    folders = [data_directory() / folder for folder in INSTANCE_FOLDERS]
    assert len(instance_files()) == sum(len(list(f.glob("*.yaml"))) for f in folders)
    assert len(NAMES) == 15


@pytest.mark.parametrize("name", NAMES)
def test_the_home_position_has_the_values(name):
    arrangement = Arrangement.of(load(instance_files()[name]))
    found = residuals(arrangement, np.eye(3), np.array([0.0, 0.0, HOME.get(name, 0.0)]))
    tolerance = ROUNDED.get(name, 4e-15 * arrangement.length)
    assert np.all(found <= tolerance), found


@pytest.mark.parametrize("name", NAMES)
def test_the_file_states_home_and_the_mode_is_found(name):
    instance = load(instance_files()[name])
    at = [0.0, 0.0, HOME.get(name, 0.0)]
    if name in HOMELESS:
        assert instance.home is None
    else:
        assert instance.home.T.tolist() == at
        assert (instance.home.R(1.0) == np.eye(3)).all()
    found = solve(instance)
    R, T = found.drawn.R[found.home.number - 1], found.drawn.T[found.home.number - 1]
    size = 1e-8 * found.arrangement.length
    assert np.abs(R - np.eye(3)).max() < 2e-7
    assert np.abs(T - at).max() < ROUNDED.get(name, size)


@pytest.mark.parametrize("name", NAMES)
def test_the_source_is_named_and_values_are_in_range(name):
    reading = read(instance_files()[name])
    assert str(reading.instance.source).startswith("https://")
    assert not [w for w in reading.warnings if "range" in w.message]
