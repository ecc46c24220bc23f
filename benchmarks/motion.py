"""Speed of what moves, on one core: `python -m benchmarks.motion`.

Figures are processor time, the least of some runs; peers are asked once.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.motion_peers import Asked, ask_all, judged
from benchmarks.motion_trajectories import (
    CYCLES,
    NEAREST,
    SEED,
    Moves,
    cycle,
    near_singularities,
    small_moves,
)
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import GspType, all_types
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowOptions, MovingPlatform, measure
from gspcli.motion.following.tracks import track_from

Array = NDArray[np.float64]

POSES = 100_000
POSES_OF_PEERS = 999
ROWS_OF_HARD_CYCLES = (50, 12)


def seconds(run: Callable[[], object], *, repeat: int = 12) -> float:
    """Return the least processor time of some runs."""
    times = []
    for _ in range(repeat):
        began = time.process_time()
        run()
        times.append(time.process_time() - began)
    return min(times)


def measured_a_second(gsp_type: GspType) -> float:
    """Return how many poses of a random platform of a type are measured in a second."""
    rng = np.random.default_rng(SEED)
    instance: Instance = random_instance(gsp_type, rng)[0]
    R = rotation_from_quaternion(rng.normal(size=(POSES, 4)))
    T = rng.uniform(-1, 1, size=(POSES, 3))
    return POSES / seconds(lambda: measure(instance, R, T), repeat=10)


@dataclass(frozen=True)
class Speed:
    """Microseconds a row and branch."""

    certified: float
    uncertified: float


def followed(moves: Moves) -> Speed:
    """Return the time of a proved segment, and of a pose that is only followed."""
    platform = MovingPlatform(moves.instance)
    inner = platform.internal(moves.values)
    start = platform.points(moves.R[:, 0], moves.T[:, 0])
    branches = np.arange(len(start))

    def run(certify: bool) -> float:
        options = FollowOptions(certify=certify)
        found = platform.follow(inner, branches, start, options)
        took = seconds(lambda: platform.follow(inner, branches, start, options))
        return took / float(found.segments.sum()) * 1e6

    return Speed(run(True), run(False))


def alone(moves: Moves) -> float:
    """Return the time of a row of one branch, from an array of values to arrays R and T."""
    platform = MovingPlatform(moves.instance)
    branch = np.zeros(1, int)

    def run() -> None:
        start = platform.points(moves.R[:1, 0], moves.T[:1, 0])
        platform.poses(platform.follow(platform.internal(moves.values[:1]), branch, start).points)

    return seconds(run, repeat=400) / len(moves.values[0, 1:]) * 1e6


def figures() -> Iterator[tuple[str, str, str]]:
    """Yield what is measured, how much it is, and the bar."""
    a_second = "poses a second"
    hexapod = measured_a_second(parse_type("6PP"))
    yield "`measure`, 6PP", f"{hexapod:,.0f} {a_second}", "1,000,000"
    types = all_types()[::77]
    speeds = {gsp_type: measured_a_second(gsp_type) for gsp_type in types}
    slowest = min(speeds, key=speeds.__getitem__)
    name = f"`measure`, slowest of {len(speeds)} types ({slowest})"
    yield name, f"{speeds[slowest]:,.0f} {a_second}", "300,000"
    trajectories = cycle(64, 1001)
    speed = followed(trajectories)
    yield "following, 6PP", f"{1e6 / speed.certified:,.0f} proved parts a second", "1,000,000"
    unproved = f"{1e6 / speed.uncertified:,.0f} {a_second}"
    yield "following, 6PP, not proved", unproved, "3,000,000"
    yield "following, 6PP, one branch alone", f"{alone(trajectories):.2f} us a proved row", "2"
    tracked = {gsp_type: followed(small_moves(gsp_type, 64, 101)) for gsp_type in types}
    for certified, what, bar in (
        (True, "proved parts a second", "100,000"),
        (False, a_second, "300,000"),
    ):
        times = {t: s.certified if certified else s.uncertified for t, s in tracked.items()}
        slowest = max(times, key=times.__getitem__)
        name = f"following, slowest of {len(times)} types ({slowest})"
        name += "" if certified else ", not proved"
        yield name, f"{1e6 / times[slowest]:,.0f} {what}", bar


def trajectories_of_peers() -> Iterator[tuple[str, Moves]]:
    """Yield what peers are asked to follow."""
    yield "small turns, one cycle", cycle(1, POSES_OF_PEERS + 1)
    for rows in ROWS_OF_HARD_CYCLES:
        what = f"the {NEAREST} of {CYCLES} wide cycles next to singularities, {rows} rows a cycle"
        yield what, near_singularities(rows + 1, rows)


def compared(moves: Moves) -> Iterator[Asked]:
    """Yield how gsp and peers follow trajectories of a hexapod, row by row."""
    answers: dict[str, list[Asked]] = {}
    for one in moves.each():
        track = track_from(one.instance, one.values[0], one.R[:, 0], one.T[:, 0])
        took = alone(one) * len(track.t[1:]) / 1e6
        ours = judged("gsp, proved", one, track.R[0], track.T[0], took)
        for answer in (ours, *ask_all(one)):
            answers.setdefault(answer.name, []).append(answer)
    for name, given in answers.items():
        yield Asked(
            name,
            float(np.mean([answer.microseconds for answer in given])),
            sum(answer.other for answer in given),
            sum(answer.unsolved for answer in given),
        )


def page() -> str:
    """Return the tables, in Markdown."""
    lines = ["| what | measured | bar |", "|---|---:|---:|"]
    lines += [f"| {' | '.join(row)} |" for row in figures()]
    lines += ["", "| a hexapod, followed along | by | us a pose | in another mode | not solved |"]
    lines.append("|---|---|---:|---:|---:|")
    for what, moves in trajectories_of_peers():
        poses = moves.values[:, 1:, 0].size
        for one in compared(moves):
            numbers = f"{one.microseconds:,.1f} | {one.other} | {one.unsolved}"
            lines.append(f"| {what}: {poses} poses | {one.name} | {numbers} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the tables."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    print(page(), end="")


if __name__ == "__main__":
    main()
