"""Poses that are followed are compared with those that were meant."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gspcli
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion import departures, measure, track
from gspcli.resources import data_path


@pytest.fixture(scope="module")
def followed():
    hexapod = gspcli.load(data_path("platforms", "simscape-hexapod.yaml"))
    home = gspcli.solve(hexapod).solutions[0]
    R = np.array([home.R @ rotation_from_vector(np.array([0.02 * k, 0, 0])) for k in range(3)])
    T = home.T + np.array([[0.01 * k, 0, 0] for k in range(3)])
    return track(hexapod, measure(hexapod, R, T), near=(R[0], T[0])), R, T


def test_the_poses_themselves_are_no_departures(followed):
    assert departures(*followed) == []


@pytest.mark.parametrize("size", [1e-1, 1e-3, 1e-5])
def test_another_place_or_turn_is_one(followed, size):
    result, R, T = followed
    length = np.abs(T).max()
    moved = T.copy()
    moved[1, 2] += size * length
    (found,) = departures(result, R, moved)
    assert (found.row, found.mode) == (1, result.modes[0])
    assert found.distance == pytest.approx(size * length)
    turned = R.copy()
    turned[2] = turned[2] @ rotation_from_vector(np.array([0, 0, size]))
    (found,) = departures(result, turned, T)
    assert (found.row, found.turn) == (2, pytest.approx(size, rel=1e-6))


def test_rounding_errors_are_none(followed):
    result, R, T = followed
    assert departures(result, R, T + 1e-9 * np.abs(T).max()) == []


def test_if_no_mode_begins_at_the_first_pose_that_is_told(followed):
    result, R, T = followed
    assert [one.row for one in departures(result, R, T + np.abs(T).max())] == [0, 1, 2]


def test_rows_without_the_mode_are_left_out(followed):
    result, R, T = followed
    ended = result.T.copy()
    ended[:, 2] = np.nan
    short = dataclasses.replace(result, T=ended)
    assert departures(short, R, T) == []
    assert departures(short, R[:0], T[:0]) == []
