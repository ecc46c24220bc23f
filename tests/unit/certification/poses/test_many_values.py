"""Proofs for many sets of values at a time, against those of single platforms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flint import arb, ctx

from gspcli import _kernel, hexapod
from gspcli.catalogue.names import parse_type
from gspcli.certification import certify
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.local_frames import OWN, StudyFrames
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import residuals
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import quaternion_from_rotation, study_from_pose
from gspcli.geometry.random_instances import random_instance
from gspcli.geometry.study import form_hessians
from gspcli.solver.study_systems import side_choices
from tests.support.oracle.poses_by_paths import solve_by_tracking

TYPES = (
    "DPP DPP DPP DPP DPP DPP",
    "DPP DPP DPP DPL DLP DLL",
    "DPH DPH DHP DHP DPP DPP",
    "DPP DPL DPH DHP ALL ALH",
    "DPP DPP DPP DPP AHL AHH",
)


class Batch:
    """A few sets of values of a geometry with the ends of their paths."""

    def __init__(self, name: str) -> None:
        rng = np.random.default_rng(21)
        self.instance, _ = random_instance(parse_type(name), rng, one_sided=True)
        arrangement = Arrangement.of(self.instance)
        self.rows = arrangement.values * (1 + 0.05 * rng.normal(size=(3, 6)))
        self.choices = side_choices(arrangement)
        poses = [solve_by_tracking(arrangement.with_values(row), seed=22) for row in self.rows]
        R, T, self.real = (
            np.array([getattr(p, name) for p in poses]) for name in ("R", "T", "real")
        )
        # Other frames, another unit and another factor for each point, as paths end.
        self.frames = StudyFrames(length=0.7, platform=(0.2, 0.1, -0.3), base=(0.1, -0.2, 0.3))
        moved = (T - self.frames.base + R @ self.frames.platform) / self.frames.length
        points = np.concatenate(study_from_pose(R, moved), axis=-1)
        factors = rng.normal(size=R.shape[:2]) + 1j * rng.normal(size=R.shape[:2])
        self.points = (points * factors[..., None])[:, None]
        self.R, self.T = R, T
        self.proofs = ValueProofs(self.instance, self.rows)

    def platform(self, k: int) -> Instance:
        values = {i: Number.of(float(value)) for i, value in enumerate(self.rows[k])}
        return self.instance.with_values(values)

    def decide(self, rows=None, points=None):
        points = self.points if points is None else points
        rows = self.rows if rows is None else rows
        return self.proofs.decide(self.choices, points, self.frames, rows=rows)


@pytest.fixture(scope="module", params=TYPES)
def batch(request):
    return Batch(request.param)


def test_what_is_proved_is_what_is_proved_of_each_platform(batch):
    found, complete = batch.decide()
    assert found.certified.mean() > 0.9
    assert (complete | ~found.certified.all(axis=1)).all()
    for k in range(len(batch.rows)):
        known = found.certified[k]
        single = certify(batch.platform(k), found.R[k, known], found.T[k, known])
        assert all(item.certified for item in single)
        np.testing.assert_array_equal(found.real[k, known], [item.real for item in single])
        np.testing.assert_array_equal(found.real[k, known], batch.real[k, known])
        np.testing.assert_allclose(found.R[k, known], batch.R[k, known], atol=1e-6)
        np.testing.assert_allclose(found.T[k, known], batch.T[k, known], atol=1e-5, rtol=1e-6)
        quaternions = quaternion_from_rotation(found.R[k, known])
        np.testing.assert_allclose(found.quaternions[k, known], quaternions, atol=1e-9)
    assert not found.R[found.real].imag.any()
    assert not found.T[found.real].imag.any()


def test_what_is_proved_of_other_values_holds_for_those(batch):
    """Newton's method may lead to solutions of other values; what is returned are those."""
    arrangement = Arrangement.of(batch.instance)
    for i in range(6):
        rows = batch.rows.copy()
        rows[:, i] *= 1 + 1e-4
        found, _ = batch.decide(rows=rows)
        assert found.certified.mean() > 0.5
        for row, given, *poses in zip(
            rows, batch.rows, found.R, found.T, found.certified, strict=True
        ):
            # Of poses far away doubles cannot measure that.
            near = poses[-1] & (np.abs(poses[0]).max(axis=(1, 2)) < 100)
            R, T = (part[near] for part in poses[:2])
            change = abs(row - given)[i]
            assert residuals(arrangement.with_values(row), R, T).max() < change / 10
            assert residuals(arrangement.with_values(given), R, T)[:, i].min() > change * 0.99


def test_far_points_are_not_certified(batch):
    rng = np.random.default_rng(3)
    noise = rng.normal(size=batch.points.shape) * np.abs(batch.points).max(axis=-1, keepdims=True)
    assert not batch.decide(points=batch.points + noise)[1].any()
    assert not batch.decide(points=np.full_like(batch.points, np.nan))[0].certified.any()
    assert not batch.decide(points=np.zeros_like(batch.points))[0].certified.any()


def test_the_other_side_of_a_plane_is_not_certified():
    batch = Batch("DPH DPH DHP DHP DPP DPP")
    batch.choices = -batch.choices
    assert not batch.decide()[1].any()


@pytest.mark.parametrize("error", [0.02, 0.005])
def test_poses_far_away_are_proved_with_more_digits(error):
    """Nearly hexagons: twelve of the poses are hundreds or thousands of lengths away."""
    rng = np.random.default_rng(25)

    def hexagon(radius, half):
        turns = np.radians([k + sign * half for k in (0, 120, 240) for sign in (-1, 1)])
        ring = radius * np.stack((np.cos(turns), np.sin(turns), 0 * turns), axis=1)
        return ring + rng.uniform(-error, error, (6, 3))

    x, y = hexagon(1, 15), hexagon(0.6, 40)
    place = np.array([0.1, 0.2, 1.5])
    lengths = np.linalg.norm(y + place - x, axis=1)
    platform = hexapod(x, y, lengths.tolist())
    arrangement = Arrangement.of(platform)
    poses = solve_by_tracking(arrangement, seed=26)
    points = np.concatenate(study_from_pose(poses.R, poses.T), axis=-1)[None, None]
    proofs = ValueProofs(platform, lengths[None])
    found, _ = proofs.decide(np.ones((1, 6)), points, OWN, rows=lengths[None])
    assert len(poses.R) == 40
    assert np.abs(found.T).max() > 100
    assert found.certified.all()
    # What is that far away 32 digits prove, but do not round correctly; else they do.
    assert found.rounded[0][np.abs(found.T[0]).max(axis=1) < 100].all()
    proofs.numbers[1][:] = np.nan
    again, _ = proofs.decide(np.ones((1, 6)), points, OWN, rows=lengths[None])
    assert not again.certified.all()
    single = certify(platform, found.R[0], found.T[0])
    assert all(item.certified for item in single)
    np.testing.assert_array_equal([item.real for item in single], found.real[0])


def _irrational(instance: Instance) -> Instance:
    """Return an instance with all its coordinates times a square root."""

    def times(numbers):
        return tuple(Number("*", (x, Number.of("sqrt(2)"))) for x in numbers)

    def moved(body):
        vectors = [value for value in vars(body).values() if isinstance(value, tuple)]
        return type(body)(*map(times, vectors))

    rows = [
        replace(row, platform=moved(row.platform), base=moved(row.base))
        for row in instance.constraints
    ]
    return replace(instance, constraints=tuple(rows))


@pytest.mark.parametrize("change", [lambda x: x, _irrational])
@pytest.mark.parametrize("name", ["DPP DPL DLP DPH DHP DLL", "DPP DPL DLL ALL ALH AHH"])
def test_the_kernel_writes_the_equations_of_ball_arithmetic(name, change):
    rng = np.random.default_rng(27)
    instance = change(random_instance(parse_type(name), rng, one_sided=True)[0])
    proofs = ValueProofs(instance, None)
    values = proofs.values(side_choices(Arrangement.of(instance)))[0, 0].tolist()
    hessians, lows, moduli, table, weights, turned = proofs.numbers
    weights = weights.tolist()
    with ctx.workprec(200):
        system = BallSystem(instance, 200)

        def exact(form):
            terms = [arb(0)] * 64
            for k, coefficient in form.items():
                for i, c in enumerate(form_hessians()[k].ravel().astype(int).tolist()):
                    terms[i] += c * coefficient
            return terms

        def written(k):
            parts = zip(hessians[k].ravel(), lows[k].ravel(), strict=True)
            return [arb(float(high)) + float(low) for high, low in parts]

        def same(wanted, found, bound):
            for x, y, size in zip(wanted, found, bound, strict=True):
                assert (x - y).abs_upper() <= 2.0**-90 * size

        for r, (row, equations) in enumerate(zip(table, system.equations, strict=True)):
            [equation] = equations
            main = written(row[0])
            bound = moduli[row[0]].copy()
            value = (arb(weights[0][r]) + weights[3][r]) * (arb(values[0][r]) + values[3][r])
            for i in range(4):
                main[9 * i] += 2 * value
                bound[i, i] += 2 * (weights[1][r] * values[1][r] + weights[2][r])
            same(exact(system.forms[equation.main]), main, bound.ravel())
            for index, k in zip(equation.squares, row[1:], strict=False):
                factor = arb(1)
                if k == turned[r]:
                    factor = system.statements[r].value
                    error = arb(values[2][r]) + values[5][r] - factor
                    assert error.abs_upper() <= 2.0**-96 * factor
                form = {i: c / factor for i, c in system.forms[index].items()}
                same(exact(form), written(k), moduli[k].ravel())


def test_poses_twice_are_not_different(batch):
    twice = np.concatenate([batch.points[:, :, :1], batch.points], axis=2)
    _, complete = batch.decide(points=twice)
    assert not complete.any()


@pytest.mark.parametrize("build", ["portable", "avx2", "avx512"])
def test_every_build_proves_the_same(build):
    order = ["portable", "avx2", "avx512"]
    if order.index(build) > order.index(_kernel.build()):
        pytest.skip(f"this processor cannot run {build}")
    batch = Batch("DPP DPP DPP DPL DLP DLL")
    given, real = _kernel.decide, []

    def other(*arguments, **options):
        real.append(build)
        return given(*arguments, **{**options, "build": build})

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_kernel, "decide", other)
        found, _ = batch.decide()
    assert real
    np.testing.assert_array_equal(found.certified, batch.decide()[0].certified)
