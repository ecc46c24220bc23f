"""The exported models in MuJoCo: loops closed, mobility, drift under gravity, driven motions."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import all_types
from gspcli.cli.main import run
from gspcli.dynamics import inverse_dynamics
from gspcli.dynamics.mass_model import MassModel
from gspcli.export import simulated_masses
from gspcli.export.mjcf import TIME_STEP, mjcf
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import METRES
from gspcli.geometry.measurement import condition_numbers, jacobian, measured
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.motion.statics.wrenches import wrenches
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tests.support.masses import random_platform
from tests.support.simulated_trees import signs

mujoco = pytest.importorskip("mujoco")

#: One sixth kind each time with five that fix what it leaves.
OF_EACH_KIND = [
    "DPP DPP DPP DPP DPP DPP",
    "DPL DPP DPP DPP DPH DHP",
    "DLP DPP DPL DPH ALL ALL",
    "DLL DPP DPP DPH DHP DLP",
    "DPP DPL DLP ALH AHL AHH",
]
#: Worse poses let the softness of MuJoCo's constraints through: drift grows with the condition.
WELL_CONDITIONED = 100
SECONDS = 2.0
#: The folder of machines that are built.
MACHINES = "platforms"
#: A step so small that poses of any condition up to that stay where they are.
FINE = 5e-5
#: Steps in one call; MuJoCo keeps the model in its own loop.
_BATCH = 1000


def _pose(arrangement, R, T, targets):
    """Return the pose near another one at which the constraints measure certain values."""
    for _ in range(50):
        twist = np.linalg.solve(jacobian(arrangement, R, T), targets - measured(arrangement, R, T))
        R, T = rotation_from_vector(twist[:3]) @ R, T + twist[3:]
        if np.abs(twist).max() < 1e-14:
            break
    return R, T


def _instance(name, seed):
    """Return a random platform with a pose that is not too badly conditioned."""
    rng = np.random.default_rng(seed)
    while True:
        instance, (R, T) = random_instance(parse_type(name), rng)
        arrangement = Arrangement.of(instance)
        if condition_numbers(arrangement, R, T) < WELL_CONDITIONED:
            return instance, arrangement, R, T


def _loaded(text):
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def _rows(model, data):
    """Return the derivatives of what holds in the model, by its joints."""
    rows = np.zeros((data.nefc, model.nv))
    if mujoco.mj_isSparse(model):
        parts = (data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
        mujoco.mju_sparse2dense(rows, data.efc_J, *parts)
    else:
        rows[:] = data.efc_J.reshape(rows.shape)
    return rows


def _mobility(model, data):
    mujoco.mj_forward(model, data)
    rows = _rows(model, data)
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    return model.nv - np.linalg.matrix_rank(rows, tol=1e-7)


def _holds(model):
    return [model.equality(f"hold_{k}").id for k in range(1, 7)]


def _run(model, data, seconds):
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)


def _platform(data):
    body = data.body("platform")
    return body.xmat.reshape(3, 3).copy(), body.xpos.copy()


def _check(name, seed, seconds):
    instance, arrangement, R, T = _instance(name, seed)
    model, data = _loaded(mjcf(instance, R, T, step=FINE))
    values = measured(arrangement, R, T)
    for k, kind in enumerate(arrangement.kinds):
        (found,) = data.joint(f"value_{k + 1}").qpos
        assert found == pytest.approx(abs(values[k]) if kind.is_distance else values[k], abs=1e-12)
    assert np.abs(data.efc_pos).max() < 1e-9
    assert _mobility(model, data) == 0
    data.eq_active[_holds(model)] = False
    assert _mobility(model, data) == 6
    data.eq_active[_holds(model)] = True
    _run(model, data, seconds)
    turned, moved = _platform(data)
    length = arrangement.length
    assert np.abs(moved - T).max() < 1e-6 * length
    assert np.abs(turned - R).max() < 1e-6


def _home(name):
    """Return the model of a shipped platform at home, loaded."""
    result = solve(load(instance_files()[name]))
    pose = result.home or result.solutions[0]
    return _loaded(mjcf(result.instance, pose.R.real, pose.T.real))


@pytest.mark.parametrize("name", ["three-vee-18.5mm", "nano-hexapod", "rubin-m2"])
def test_springs_hold_in_proportion_to_the_size(name):
    model, data = _home(name)
    _, before = _platform(data)
    data.eq_active[_holds(model)] = False
    _run(model, data, 0.6)
    assert np.abs(data.qvel).max() < 1e-6
    # The model shows three sizes.
    assert np.linalg.norm(_platform(data)[1] - before) < 1e-4 * model.stat.extent


@pytest.mark.parametrize("name", ["nano-hexapod", "octahedral-3-3", "at random"])
def test_bodies_are_hulls_over_a_floor(name):
    if name == "at random":
        # A base that is not flat.
        rng = np.random.default_rng(5)
        instance, (R, T) = random_instance(parse_type("DPP DPP DPP DPP DPP DPP"), rng)
        model, data = _loaded(mjcf(instance, R, T))
    else:
        model, data = _home(name)
    height = data.geom("floor").xpos[2]
    for body in ("base", "platform"):
        mesh = model.mesh(body)
        (geom,) = np.flatnonzero(model.geom_dataid == mesh.id)
        first, count = int(mesh.vertadr[0]), int(mesh.vertnum[0])
        corners = model.mesh_vert[first : first + count] @ data.geom_xmat[geom].reshape(3, 3).T
        corners = corners + data.geom_xpos[geom]
        assert corners[:, 2].min() > height
        # Every joint is a corner of the hull, or in it: the balls at the joints say where they are.
        owner = model.geom_bodyid[geom]
        balls = (model.geom_bodyid == owner) & (model.geom_type == mujoco.mjtGeom.mjGEOM_SPHERE)
        assert balls.sum() == 6
        thick = 0.02 * model.stat.extent
        assert (data.geom_xpos[balls] >= corners.min(axis=0) - thick).all()
        assert (data.geom_xpos[balls] <= corners.max(axis=0) + thick).all()


def test_bodies_in_one_point_have_no_hulls():
    model, _ = _home("example-6.8")
    assert model.nmesh == 0


@pytest.mark.parametrize("name", OF_EACH_KIND)
def test_loops_are_closed_and_the_platform_stays(name):
    _check(name, 7, 0.05)


def test_the_sample_has_every_kind():
    kinds = {kind for name in OF_EACH_KIND for kind in parse_type(name).kinds}
    assert kinds == {*DISTANCE_KINDS, *ANGLE_KINDS}


@pytest.mark.slow
@pytest.mark.parametrize("name", OF_EACH_KIND)
def test_of_every_kind_stay_for_two_seconds(name):
    _check(name, 7, SECONDS)


def _sag(name, step):
    """Return how far gravity pulls a machine in a quarter of a second, in lengths."""
    instance = load(instance_files()[name])
    result = solve(instance)
    mode = int(result.conditions[: result.counts.real].argmin())
    model, data = _loaded(mjcf(instance, result.R[mode].real, result.T[mode].real, step=step))
    before = _platform(data)
    _run(model, data, 0.25)
    turned, moved = (np.abs(b - a).max() for a, b in zip(before, _platform(data), strict=True))
    length = Arrangement.of(instance).length * METRES.get(instance.units.length, 1.0)
    return max(turned, moved / length)


@pytest.mark.parametrize(
    "name", sorted(n for n, p in instance_files().items() if MACHINES in p.parts)
)
def test_every_machine_stays_with_the_usual_step(name):
    assert _sag(name, TIME_STEP) < 1e-7


def test_the_platform_gives_way_by_the_square_of_the_step():
    assert _sag("rubin-m2", TIME_STEP) == pytest.approx(100 * _sag("rubin-m2", FINE), rel=0.02)


_RANDOM = np.random.default_rng(2003).choice(len(all_types()), 100, replace=False) + 1


@pytest.mark.slow
@pytest.mark.parametrize("number", _RANDOM)
def test_random_types_stay_for_two_seconds(number):
    _check(str(number), int(number), SECONDS)


def _path(arrangement, R, T, values, change):
    """Return where the pose goes when the values move along a line; None at a singularity."""
    for part in np.linspace(0, 1, 21)[1:]:
        before = R, T
        R, T = _pose(arrangement, R, T, values + part * change)
        moved = np.abs(R - before[0]).max() + np.abs(T - before[1]).max() / arrangement.length
        if moved > 0.1 or condition_numbers(arrangement, R, T) > WELL_CONDITIONED:
            return None
    return R, T


def _tracked(instance, start, end):
    """Return where `track` leads from a pose when the values become those of another."""
    values = [measure(instance, *start), measure(instance, *end)]
    track = gspcli.track(instance, values, near=start)
    assert track.certified
    assert not track.events
    R, T = track.R[0, -1], track.T[0, -1]
    assert np.abs(R - end[0]).max() < 1e-9
    return R, T


def _driven(name, seed, seconds):
    """Move all values a little and compare where the platform arrives with what track says."""
    instance, arrangement, R, T = _instance(name, seed)
    # Without weight: the values move, nothing else.
    model, data = _loaded(mjcf(instance, R, T, gravity=0.0))
    values = measured(arrangement, R, T)
    distances = np.array([kind.is_distance for kind in arrangement.kinds])
    change = 0.005 * np.where(distances, arrangement.length, 1.0)
    change *= np.random.default_rng(seed).choice([-1, 1], 6)
    # The joints' distances are not negative.
    signs = np.where(distances, np.sign(values), 1.0)
    while (expected := _path(arrangement, R, T, values, signs * change)) is None:
        change /= 2
    expected = _tracked(instance, (R, T), expected)
    count = round(seconds / model.opt.timestep)
    for step in range(count):
        # Starts and ends at rest.
        done = (1 - np.cos(np.pi * (step + 1) / count)) / 2
        model.eq_data[_holds(model), 0] = done * change
        mujoco.mj_step(model, data)
    _run(model, data, 0.02)
    turned, moved = _platform(data)
    way = np.abs(moved - T).max() / arrangement.length + np.abs(turned - R).max()
    assert np.abs(moved - expected[1]).max() < 1e-5 * arrangement.length
    assert np.abs(turned - expected[0]).max() < 1e-5
    assert way > 1e-4


@pytest.mark.parametrize("name", OF_EACH_KIND)
def test_a_driven_platform_arrives_where_track_says(name):
    _driven(name, 7, 0.2)


@pytest.mark.slow
@pytest.mark.parametrize("number", _RANDOM[:30])
def test_random_types_arrive_where_track_says(number):
    _driven(str(number), int(number), 1.0)


@pytest.mark.parametrize("name", sorted({*instance_files()} - {"parallel-edges"}))
def test_special_platforms_can_be_built(name):
    real = solve(load(instance_files()[name])).real_solutions
    if not real:
        pytest.skip("no real pose")
    instance = load(instance_files()[name])
    model, data = _loaded(mjcf(instance, real[0].R.real, real[0].T.real, step=FINE))
    assert np.abs(data.efc_pos).max() < 1e-9
    _run(model, data, 0.005)
    assert np.abs(data.efc_pos).max() < 1e-7


@pytest.mark.parametrize("name", OF_EACH_KIND)
def test_derivatives_rank_and_forces_are_those_of_the_simulator(name):
    """What `gsp analyze` says, against a simulator that has only joints and welds."""
    instance, arrangement, R, T = _instance(name, 11)
    model, data = _loaded(mjcf(instance, R, T, gravity=0.0))
    analyzed = wrenches(instance, R, T)
    # In the model distances are not negative.
    distances = np.array([kind.is_distance for kind in arrangement.kinds])
    signs = np.where(distances, np.sign(measured(arrangement, R, T)), 1.0)
    # Freely: the motions of the joints that keep the loops closed.
    data.eq_active[_holds(model)] = False
    mujoco.mj_forward(model, data)
    _, sizes, right = np.linalg.svd(_rows(model, data))
    free = right[np.count_nonzero(sizes > 1e-9 * sizes[0]) :]
    assert len(free) == 6
    places = np.zeros((2, 3, model.nv))
    body = model.body("platform").id
    mujoco.mj_jac(model, data, places[1], places[0], analyzed.point, body)
    twists = np.concatenate(places) @ free.T
    joints = [model.joint(f"value_{k}").dofadr[0] for k in range(1, 7)]
    found = free[:, joints].T @ np.linalg.inv(twists) * signs[:, None]
    assert np.allclose(found, analyzed.jacobian, atol=1e-7 * np.abs(analyzed.jacobian).max())
    assert np.linalg.matrix_rank(found) == 6
    # Held: what holds the values while a load acts.
    data.eq_active[_holds(model)] = True
    rng = np.random.default_rng(1)
    force, moment = rng.normal(size=(2, 3))
    at = T + 0.3 * rng.normal(size=3)
    mujoco.mj_applyFT(model, data, force, moment, at, body, data.qfrc_applied)
    _run(model, data, 0.05)
    held = np.array([data.efc_force[data.efc_id == number].sum() for number in _holds(model)])
    expected = analyzed.reactions(force, moment, at) * signs
    assert np.allclose(held, expected, rtol=2e-3, atol=2e-3 * np.abs(expected).max())
    # Not by chance: a load elsewhere is held otherwise.
    other = analyzed.reactions(force, moment, at + 0.1) * signs
    assert not np.allclose(held, other, rtol=2e-3, atol=2e-3 * np.abs(expected).max())


def test_a_command_writes_the_model(tmp_path, capsys):
    target = tmp_path / "model.xml"
    assert run(["export", "@rubin-m2", "--to", "mjcf", "-o", str(target)]) == 0
    model, _ = _loaded(target.read_text(encoding="utf-8"))
    assert (model.nv, model.nu) == (42, 6)
    assert run(["export", "@no-real-pose", "--to", "mjcf"]) == 2
    assert "no real pose for its values" in capsys.readouterr().err


@pytest.mark.parametrize("name", OF_EACH_KIND)
def test_stated_masses_are_those_of_the_model(name, monkeypatch):
    # Heavier links add more inertia and settle sooner.
    monkeypatch.setattr(simulated_masses, "LIGHT", 1e-2)
    rng = np.random.default_rng(12)
    instance, R, T = random_platform(name, rng, legs=True)
    stated = MassModel.of(instance)
    model, data = _loaded(mjcf(instance, R, T, step=FINE))
    body = model.body("platform")
    assert body.mass[0] == stated.mass
    assert np.allclose(body.ipos, stated.centre)
    assert np.allclose(np.sort(body.inertia), np.linalg.eigvalsh(stated.inertia))
    assert np.array_equal(model.opt.gravity, stated.gravity)
    # What gravity pulls at weighs as much as the platform and its legs.
    falling = model.body_mass[model.body_gravcomp == 0].sum()
    legs = stated.legs.cylinder[0].sum() + stated.legs.rod[0].sum()
    assert falling == pytest.approx(stated.mass + legs)
    # Held: the loops stay closed, and the values are held by the forces that are computed.
    assert _mobility(model, data) == 0
    _run(model, data, 0.1)
    _, moved = _platform(data)
    assert np.abs(moved - T).max() < 1e-6 * Arrangement.of(instance).length
    held = np.array([data.efc_force[data.efc_id == number].sum() for number in _holds(model)])
    expected = inverse_dynamics(instance, R, T).forces[0] * signs(instance, R, T)
    assert np.abs(held - expected).max() < 1e-3 * np.abs(expected).max()
