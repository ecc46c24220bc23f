"""The same platform gives the same bytes, however its poses are found; each is rounded correctly.

What is compared are the numbers of certified poses, the verdict and the counts.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.catalogue.names import parse_type
from gspcli.certification import certify, refine
from gspcli.certification.equations.local_frames import OWN
from gspcli.certification.numbers.correct_rounding import GRID, SMALL
from gspcli.certification.poses.locator import Locator
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import residuals, sides_of
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import track
from gspcli.resources import data_path
from gspcli.solver import all_poses, solve, solve_batch, solve_values
from gspcli.solver.poses import PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import SolvedStarts

#: Files: general and special geometries, and lines; types: all relations, sides and angles.
FILES = (
    "examples/dietmaier",
    "examples/octahedral-3-3",
    "examples/platform-6-4",
    "examples/surfaces-psc",
    "examples/no-real-pose",
    "platforms/nano-hexapod",
    "platforms/rubin-m2",
    "platforms/linuxcnc-hexapod",
)
TYPES = ("6PP", "5PP PL", "3PP 2PH ALL", "2PL LP 3AHH", "DPH DHP DLL ALL ALH AHH", "6D 4PP PL LL")
GEOMETRIES = ("6PP", "3PP 2PH ALL", "2PL LP 3AHH", "DPH DHP DLL ALL ALH AHH", "6D 4PP PL LL")
NAMES = (*FILES, *TYPES)
#: Machines that are special up to the rounding of their numbers, and how far values change.
FAR = [
    ("platforms/reachy-mini-head", 0.2),
    ("platforms/rubin-camera", 0.01),
    ("platforms/modified-paradex", 0.1),
]
PARTS = ("quaternions", "R", "T", "real", "multiplicity")


@cache
def platform(name: str) -> Instance:
    folder, _, file = name.partition("/")
    if file:
        from gspcli.spec import load

        return load(data_path(folder, f"{file}.yaml"))
    return random_instance(parse_type(name), np.random.default_rng(3))[0]


def said(poses: PoseSet) -> tuple[object, ...]:
    """Return what is to be the same, the numbers of certified poses as bytes."""
    chosen = poses.certified
    numbers = tuple(getattr(poses, part)[chosen].tobytes() for part in PARTS)
    account = poses.account
    return (*numbers, account.verdict, account.expected, account.found, len(poses.R))


@cache
def known(name: str) -> tuple[object, ...]:
    """Return the output for a platform of which nothing is kept."""
    return said(solve(platform(name), starts=SolvedStarts()))


@pytest.mark.parametrize("name", NAMES)
def test_whatever_came_before(name: str) -> None:
    starts, instance = SolvedStarts(), platform(name)
    for _ in range(3):
        assert said(solve(instance, starts=starts)) == known(name)


def test_in_whatever_order() -> None:
    starts = SolvedStarts()
    for name in np.random.default_rng(1).permutation(NAMES * 2).tolist():
        assert said(solve(platform(name), starts=starts)) == known(name)


@pytest.mark.parametrize("name", NAMES)
def test_whatever_the_seed_and_the_threads(name: str) -> None:
    for options in ({"seed": 1}, {"seed": 77, "jobs": 2}):
        poses = solve(platform(name), starts=SolvedStarts(), **options)
        assert said(poses) == known(name)


@pytest.mark.parametrize("build", ["portable", "avx2", "avx512"])
def test_whatever_the_processor(build: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Proofs by another build of the kernel, and paths by another."""
    order = ["portable", "avx2", "avx512"]
    if order.index(build) > order.index(_kernel.build()):
        pytest.skip(f"this processor cannot run {build}")
    for name in ("decide", "track", "track_values", "track_reduced"):
        given = getattr(_kernel, name)
        monkeypatch.setattr(
            _kernel, name, lambda *a, _given=given, **k: _given(*a, **{**k, "build": build})
        )
    for name in NAMES:
        assert said(solve(platform(name), starts=SolvedStarts())) == known(name)


@pytest.mark.parametrize("name", NAMES)
def test_whatever_strategy_finds_them(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Careful paths from the start; and the others, where doubles prove nothing."""
    instance = platform(name)
    with monkeypatch.context() as patch:
        patch.setattr(all_poses, "_first_of_one", lambda: (all_poses.careful_paths,))
        assert said(solve(instance, starts=SolvedStarts())) == known(name)


@pytest.mark.parametrize("name", ["examples/dietmaier", "6PP", "2PL LP 3AHH"])
def test_whether_the_kernel_proves_them_or_balls(name: str, monkeypatch) -> None:
    monkeypatch.setattr(Problem, "proofs", None)
    assert said(solve(platform(name), starts=SolvedStarts())) == known(name)


def test_whether_doubles_or_more_digits_find_them(monkeypatch) -> None:
    monkeypatch.setattr(all_poses, "_first_of_one", lambda: ())
    assert said(solve(platform("6PP"), starts=SolvedStarts())) == known("6PP")


@pytest.mark.parametrize("name", GEOMETRIES)
def test_whether_alone_or_among_many(name: str) -> None:
    instance = platform(name)
    own = np.array([row.value.value for row in instance.constraints])
    rows = own * (1 + 0.01 * np.random.default_rng(2).normal(size=(6, 6)))
    exactly = [{i: Number.of(Fraction(x)) for i, x in enumerate(row.tolist())} for row in rows]
    alone = [
        said(solve(instance.with_values(numbers), starts=SolvedStarts())) for numbers in exactly
    ]
    for chosen, options in ((slice(None), {"jobs": 2}), (slice(None), {"seed": 5}), ([2, 4], {})):
        starts = SolvedStarts()
        for _ in range(2):
            many = solve_values(instance, rows[chosen], starts=starts, **options)
            expected = np.array(alone, object)[chosen].tolist()
            length = Arrangement.of(instance).length
            assert [list(said(one.in_order(length))) for one in many] == expected
    batch = solve_batch(instance, rows, starts=SolvedStarts())
    for k, poses in enumerate(solve_values(instance, rows, starts=SolvedStarts())):
        number = batch.number[k]
        for part in ("R", "T", "real", "multiplicity"):
            assert getattr(batch, part)[k, :number].tobytes() == getattr(poses, part).tobytes()


def far(instance: Instance) -> Instance:
    """Return a platform in the frames of a workshop, thousands of lengths away."""

    def moved(geometry: Geometry, by: tuple[int, int, int]) -> Geometry:
        numbers = [
            Number.of((x.fraction if x.fraction is not None else Fraction(x.value)) + step)
            for x, step in zip(geometry.position, by, strict=True)
        ]
        return replace(geometry, position=vector(*numbers))

    rows = [
        replace(
            row,
            platform=moved(row.platform, (-30000, 12000, 7000)),
            base=moved(row.base, (40000, -25000, 9000)),
        )
        for row in instance.constraints
    ]
    return replace(instance, constraints=tuple(rows))


@pytest.mark.parametrize("name", ["platforms/nano-hexapod", "6PP", "3PP 2PH ALL"])
def test_in_frames_far_away(name: str) -> None:
    """There the nano-hexapod is not quite symmetric: entries of 1e-17 that are not zero."""
    instance = far(platform(name))
    expected, starts = said(solve(instance, starts=SolvedStarts())), SolvedStarts()
    for seed, jobs in ((3, 1), (5, 2), (5, 1)):
        assert said(solve(instance, seed=seed, jobs=jobs, starts=starts)) == expected


@pytest.mark.parametrize("name", ["platforms/nano-hexapod", "6PP", "2PL LP 3AHH"])
def test_rows_of_a_track(name: str) -> None:
    """Along with others or alone, after other calls and in threads; and the modes of `solve`."""
    instance = platform(name)
    own = np.array([row.value.value for row in instance.constraints])
    rows = own * (1 + 0.001 * np.random.default_rng(2).normal(size=(4, 6)))
    found = track(instance, rows)
    assert found.certified
    solve(instance, starts=SolvedStarts(), seed=3)
    again, mode = track(instance, rows, jobs=2, seed=9), track(instance, rows, modes=[2])
    for part in ("R", "T", "quaternions"):
        numbers = getattr(found, part)
        assert getattr(again, part).tobytes() == numbers.tobytes()
        assert getattr(mode, part)[0].tobytes() == numbers[1].tobytes()
        assert getattr(track(instance, rows[:2]), part).tobytes() == numbers[:, :2].tobytes()
    length = Arrangement.of(instance).length
    for k, row in enumerate(rows.tolist()):
        numbers = {i: Number.of(Fraction(x)) for i, x in enumerate(row)}
        result = solve(instance.with_values(numbers), starts=SolvedStarts())
        R, T = result.R[result.real].real, result.T[result.real].real
        for turn, place in zip(found.R[:, k], found.T[:, k], strict=True):
            off = np.abs(R - turn).max(axis=(1, 2)) + np.abs(T - place).max(axis=1) / length
            assert (off < 1e-13).sum() == 1


@pytest.mark.parametrize(("name", "spread"), FAR)
def test_whether_far_poses_are_kept(name: str, spread: float) -> None:
    """Known for other values, alone and among many, or found again."""
    instance, starts = platform(name), SolvedStarts()
    solve(instance, starts=starts)
    own = np.array([row.value.value for row in instance.constraints])
    rows = own * (1 + spread * np.random.default_rng(2).uniform(-1, 1, size=(6, 6)))
    batch = list(solve_values(instance, rows, starts=starts))
    length = Arrangement.of(instance).length
    for k, row in enumerate(rows[:2]):
        other = instance.with_values(
            {i: Number.of(Fraction(x)) for i, x in enumerate(row.tolist())}
        )
        kept = solve(other, starts=starts)
        assert said(kept) == said(batch[k].in_order(length))
        assert said(kept) == said(solve(other, starts=SolvedStarts()))
        assert kept.proof is not None


def test_rows_of_a_batch_are_as_precise_as_one_alone() -> None:
    """Planes of both bodies only, values far from those that were solved first."""
    instance = platform("6D 3PH 3HP")
    own = np.array([row.value.value for row in instance.constraints])
    rows = own * np.random.default_rng(6).uniform(0.7, 1.3, (200, 6))
    batch = solve_batch(instance, rows, starts=SolvedStarts())
    arrangement = Arrangement.of(instance)
    for k, number in enumerate(batch.number.tolist()):
        R, T = batch.R[k, :number], batch.T[k, :number]
        assert batch.certified[k, :number].all()
        errors = residuals(arrangement.with_values(rows[k]), R, T).max(axis=1)
        # Heights are sums of products of two numbers of a pose, which may be complex and large.
        sizes = 1 + np.abs(R).max(axis=(1, 2)) * np.abs(T).max(axis=1)
        assert (errors < 1e-14 * arrangement.length * sizes).all()
    for k in range(0, 200, 25):
        numbers = {i: Number.of(Fraction(x)) for i, x in enumerate(rows[k].tolist())}
        alone = solve(instance.with_values(numbers), starts=SolvedStarts())
        assert in_any_order(batch.R[k], batch.T[k]) == in_any_order(alone.R, alone.T)


def in_any_order(R: np.ndarray, T: np.ndarray) -> list[bytes]:
    poses = np.concatenate((R.reshape(-1, 9), T), axis=1).astype(complex)
    return sorted(pose.tobytes() for pose in poses)


@pytest.mark.parametrize("name", NAMES)
def test_each_double_is_the_correct_rounding(name: str) -> None:
    """Against balls of 512 bits, located again."""
    instance = platform(name)
    result = solve(instance, starts=SolvedStarts())
    chosen = np.flatnonzero(result.certified)[:40]
    assert len(chosen)
    locator = Locator(instance, OWN)
    R, T = result.R[chosen].astype(complex), result.T[chosen].astype(complex)
    signs = sides_of(result.arrangement, R, T).tolist()
    for k, sides in zip(chosen.tolist(), map(locator.sides, signs), strict=True):
        found = locator.near(result.R[k] + 0j, result.T[k] + 0j, sides, 512)
        assert found.R.tobytes() == (result.R[k] + 0j).tobytes()
        assert found.T.tobytes() == (result.T[k] + 0j).tobytes()
        assert found.quaternion.tobytes() == (result.quaternions[k] + 0j).tobytes()


@pytest.mark.parametrize("name", ["examples/dietmaier", "5PP PL", "DPH DHP DLL ALL ALH AHH"])
def test_decimals_say_the_same(name: str) -> None:
    """Against what `refine` prints: decimals that share no rounding with doubles."""
    instance = platform(name)
    result = solve(instance, starts=SolvedStarts())
    R, T = result.R[:6], result.T[:6]
    for certificate, turn, place in zip(certify(instance, R, T), R, T, strict=True):
        exact = refine(instance, certificate, 40)
        for real, imag, doubles, least in (
            (exact.R, exact.R_imag, turn, 0.0),
            (exact.T, exact.T_imag, place, Locator(instance, OWN).scale),
        ):
            parts = [np.ravel(np.array(real))]
            parts += [np.ravel(np.array(imag))] if imag is not None else []
            numbers = [[Fraction(x) for x in part] for part in parts]
            given = [np.ravel(doubles).real.tolist(), np.ravel(doubles).imag.tolist()]
            largest = max(abs(float(x)) for part in numbers for x in part)
            unit = Fraction(max(least, 2.0 ** math.frexp(largest)[1]))
            for some, ours in zip(numbers, given, strict=False):
                assert ours == [nearest(x, unit) for x in some]


def nearest(number: Fraction, unit: Fraction) -> float:
    """Return the double nearest to a number, or the multiple of the grid if it is small."""
    if abs(number) >= SMALL * unit:
        return float(number)
    return float(round(number / (GRID * unit)) * GRID * unit)
