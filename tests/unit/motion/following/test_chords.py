from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.certification.branches.chord_residuals import ExactChords
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.defaults import SEED
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import MovingPlatform, measure
from gspcli.motion.following import branch_runs as running
from gspcli.motion.following import branch_steps as stepping
from gspcli.motion.following import chords
from gspcli.motion.following.chord_bends import Bends
from gspcli.motion.following.chord_equations import DEGREE, Chord, Parts, equations_at
from gspcli.motion.following.chords import prove


def moved(kinds, seed, step):
    """A random platform, and two poses near each other with what they measure."""
    rng = np.random.default_rng(seed)
    instance, (R, T) = random_instance(gspcli.parse_type(kinds), rng)
    there = T + step * rng.normal(size=3)
    values = np.stack([measure(instance, R, pose) for pose in (T, there)])
    platform = MovingPlatform(instance)
    first, last = (platform.points(R[None], pose[None]) for pose in (T, there))
    last *= np.sign(np.sum(first * last))
    system = MovingSystem(instance, ())
    piece = system.on_part((values[0], values[1]), 0.0, 1.0).restricted(-0.5, 0.5, DEGREE)
    return system, (values[0], values[1]), piece, first, last


@pytest.mark.parametrize("kinds", ["6PP", "6PL", "6DLL", "PP PL LP DLL ALL AHL"])
def test_second_derivatives_are_those_of_the_equations(kinds):
    system, _, piece, first, last = moved(kinds, 3, 0.05)
    parts = Parts.of(system.shapes, [piece])
    z, d = (first + last) / 2, last - first
    chord = Chord(parts, z, d)
    bends = Bends(parts, chord)
    for tau in (-0.5, 0.0, 0.3):
        powers = tau ** np.arange(bends.values.shape[2])
        found = np.einsum("d,rdxy->rxy", powers, bends.values[0])
        quadrics = np.einsum("nkqdxy,d->nkqxy", parts.quadrics, powers[: DEGREE + 1])
        factors = parts.factors @ powers[: parts.factors.shape[2]]

        def slopes(point, quadrics=quadrics, factors=factors):
            return equations_at(system.shapes, quadrics, factors, point)[1][0]

        point, size = z + tau * d, 1e-5
        for k, step in enumerate(size * np.eye(8)):
            difference = (slopes(point + step) - slopes(point - step)) / (2 * size)
            assert np.allclose(found[..., k], difference, rtol=1e-7, atol=1e-8)
            # And how far they can be from there.
            beyond = (slopes(point + 101 * step) - slopes(point + 99 * step)) / (2 * size)
            change = np.linalg.norm(beyond - difference, axis=1)
            assert (change <= 100 * size * bends.thirds[0] + 1e-6).all()


@pytest.mark.parametrize("kinds", ["6PP", "6PL", "6DLL", "PP PL LP DLL ALL AHL"])
def test_proofs_in_other_norms_hold_in_the_euclidean_one(kinds, monkeypatch):
    """The zeros at both ends are as near as is proved, and in no norm anything else is proved."""
    system, rows, piece, first, last = moved(kinds, 3, 2e-3)
    parts = Parts.of(system.shapes, [piece])
    exact = [ExactChords(system, rows, 0.0, 1.0)]
    off = last + 1e-9 * np.random.default_rng(0).normal(size=8)
    plain = prove(parts, first, off)
    for exponent in chords.EXPONENTS:
        monkeypatch.setattr(chords, "EXPONENTS", (exponent,))
        monkeypatch.setattr(chords, "EASY", 0.0)
        found = prove(parts, first, off, exact)
        assert found.measure <= plain.measure
        if found.measure < 1:
            truth = last / np.sum(off * last) * np.sum(off * off)
            assert np.linalg.norm(truth - off) < 2 * found.end
            assert found.end < found.uniqueness


def random_move(kinds, number, k):
    """One of the moves of tools/verify/tracks.py."""
    rng = np.random.default_rng((SEED, number, k))
    instance, (R, T) = random_instance(gspcli.parse_type(kinds), rng)
    turned = rotation_from_vector(0.3 * rng.normal(size=3)) @ R
    values = [measure(instance, R, T), measure(instance, turned, T + 0.3 * rng.normal(size=3))]
    return instance, np.stack(values)


def test_towards_a_fold_nothing_is_given_up():
    """Lines that are nearly parallel, and more than fifty tries; two modes meet."""
    instance, values = random_move("DPP DPP DLL ALH ALH ALH", 111, 35)
    events = gspcli.motion.track(instance, values).events
    assert {event.kind for event in events} == {"fold"}
    assert len({round(event.low, 12) for event in events}) * 2 == len(events)


def test_modes_that_go_to_infinity_are_given_up(monkeypatch):
    """They move mainly along one singular direction, in steps of which there would be thousands."""
    instance, values = random_move("DPH DLL DLL ALH AHL AHH", 1035, 29)
    tries = []

    def follow_closely(*arguments):
        found = stepping.follow_closely(*arguments)
        tries.extend(found.tries)
        return found

    monkeypatch.setattr(running, "follow_closely", follow_closely)
    track = gspcli.motion.track(instance, values[::-1])
    lost = [event for event in track.events if event.kind == "undecided"]
    assert len(lost) == 4
    assert all(event.reason.startswith("the platform goes far away") for event in lost)
    # In the Euclidean norm, and without looking where the platform is, it takes a thousand each.
    assert max(tries, default=0) < 100
