"""Speed of what moves, on one core: `OPENBLAS_NUM_THREADS=1 python -m bench.motion [--write]`.

With ``--write`` the table in docs/motion.md is written anew. Figures are processor time, the least
of some runs; peers are asked once.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.motion_peers import RIGHT, Asked, ask_all
from gspcli.catalogue.parsing import parse_type
from gspcli.catalogue.types import GspType, all_types
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.motion import FollowOptions, MovingPlatform, measure
from gspcli.solver.generate import random_instance
from gspcli.spec import loads

Array = NDArray[np.float64]

SEED = 2003
POSES = 100_000
POSES_OF_PEERS = 999
PAGE = Path(__file__).resolve().parents[1] / "docs" / "motion.md"
_BEGIN, _END = "<!-- speed -->\n", "<!-- end of speed -->\n"


def seconds(run: Callable[[], object], *, repeat: int = 5) -> float:
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
    return POSES / seconds(lambda: measure(instance, R, T), repeat=3)


@dataclass(frozen=True)
class Speed:
    """Microseconds a row and branch."""

    certified: float
    uncertified: float


def cycle(branches: int, rows: int) -> tuple[Instance, Array, Array, Array]:
    """Return a usual hexapod and smooth closed trajectories: R, T and the values."""
    angles = np.radians([[55, 65, 175, 185, 295, 305], [10, 110, 130, 230, 250, 350]])
    sizes = np.array([0.5, 1.0])[:, None]
    corners = np.stack((sizes * np.cos(angles), sizes * np.sin(angles)), axis=-1).round(6)
    instance = loads(_HEXAPOD.format(*corners.reshape(-1).tolist()))
    rng = np.random.default_rng(SEED)
    phases = rng.uniform(-np.pi, np.pi, (branches, 1, 6))
    t = np.linspace(0, 2 * np.pi, rows)[None, :, None]
    c = np.sin(t * (1 + np.arange(6) % 3) + phases)
    R = rotation_from_quaternion(
        np.concatenate((np.ones((branches, rows, 1)), 0.17 * c[..., :3]), axis=-1)
    )
    T = np.stack((0.25 * c[..., 3], 0.25 * c[..., 4], 1 + 0.15 * c[..., 5]), axis=-1)
    return instance, R, T, measure(instance, R, T)


_HEXAPOD = (
    "gsp: 1\nunits: {{length: m, angle: deg}}\nplatform:\n"
    + "".join(f"  P{k}: {{{{point: [{{}}, {{}}, 0]}}}}\n" for k in range(6))
    + "base:\n"
    + "".join(f"  B{k}: {{{{point: [{{}}, {{}}, 0]}}}}\n" for k in range(6))
    + "constraints:\n"
    + "".join(f"  - {{{{distance: [P{k}, B{k}], value: 1}}}}\n" for k in range(6))
)


def small_moves(
    gsp_type: GspType, branches: int, rows: int
) -> tuple[Instance, Array, Array, Array]:
    """Return a random platform of a type and short smooth trajectories from its pose."""
    rng = np.random.default_rng(SEED)
    instance, (R, T) = random_instance(gsp_type, rng)
    t = np.linspace(0, 1, rows)[None, :, None]
    turn, move = rng.normal(size=(2, branches, 1, 3)) * 0.01
    R, T = rotation_from_vector(t * turn) @ R, T + t * move
    return instance, R, T, measure(instance, R, T)


def followed(instance: Instance, R: Array, T: Array, values: Array) -> Speed:
    """Return the time of a proved segment, and of a pose that is only followed."""
    platform = MovingPlatform(instance)
    inner, start = platform.internal(values), platform.points(R[:, 0], T[:, 0])
    branches = np.arange(len(R))

    def run(certify: bool) -> float:
        options = FollowOptions(certify=certify)
        found = platform.follow(inner, branches, start, options)
        took = seconds(lambda: platform.follow(inner, branches, start, options))
        return took / float(found.segments.sum()) * 1e6

    return Speed(run(True), run(False))


def alone(instance: Instance, R: Array, T: Array, values: Array) -> float:
    """Return the time of a row of one branch, from an array of values to arrays R and T."""
    platform = MovingPlatform(instance)
    branch = np.zeros(1, int)

    def run() -> None:
        start = platform.points(R[:1, 0], T[:1, 0])
        platform.poses(platform.follow(platform.internal(values[:1]), branch, start).points)

    return seconds(run) / (values.shape[1] - 1) * 1e6


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
    speed = followed(*trajectories)
    yield "following, 6PP", f"{1e6 / speed.certified:,.0f} proved parts a second", "1,000,000"
    unproved = f"{1e6 / speed.uncertified:,.0f} {a_second}"
    yield "following, 6PP, not proved", unproved, "3,000,000"
    yield "following, 6PP, one branch alone", f"{alone(*trajectories):.2f} us a proved row", "2"
    tracked = {gsp_type: followed(*small_moves(gsp_type, 64, 101)) for gsp_type in types}
    for certified, what, bar in (
        (True, "proved parts a second", "100,000"),
        (False, a_second, "300,000"),
    ):
        times = {t: s.certified if certified else s.uncertified for t, s in tracked.items()}
        slowest = max(times, key=times.__getitem__)
        name = f"following, slowest of {len(times)} types ({slowest})"
        name += "" if certified else ", not proved"
        yield name, f"{1e6 / times[slowest]:,.0f} {what}", bar


def compared() -> Iterator[Asked]:
    """Yield how peers and gsp follow one trajectory of a hexapod, 999 rows one after the other."""
    instance, R, T, values = cycle(1, POSES_OF_PEERS + 1)
    platform = MovingPlatform(instance)
    start, branch = platform.points(R[:, 0], T[:, 0]), np.zeros(1, int)
    found = platform.follow(platform.internal(values), branch, start)
    rotations, places = platform.poses(found.points)
    right = (np.abs(rotations - R).max(axis=(2, 3)) < RIGHT) & (
        np.abs(places - T).max(axis=2) < RIGHT
    )
    yield Asked("gsp, proved", alone(instance, R, T, values), int((~right).sum()), 0)
    yield from ask_all(instance, R[0], T[0], values[0])


def page() -> str:
    """Return the tables, in Markdown."""
    lines = ["| what | measured | bar |", "|---|---:|---:|"]
    lines += [f"| {' | '.join(row)} |" for row in figures()]
    lines += ["", f"| {POSES_OF_PEERS} rows of one trajectory of a hexapod, by | us a pose | "]
    lines[-1] += "in another mode | not solved |"
    lines.append("|---|---:|---:|---:|")
    for one in compared():
        lines.append(f"| {one.name} | {one.microseconds:,.1f} | {one.other} | {one.unsolved} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print or write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/motion.md anew")
    arguments = parser.parse_args()
    tables = page()
    if not arguments.write:
        print(tables, end="")
        return
    text = PAGE.read_text(encoding="utf-8")
    (before, rest), after = text.split(_BEGIN, 1), text.split(_END, 1)[1]
    assert _END in rest
    PAGE.write_text(f"{before}{_BEGIN}\n{tables}\n{_END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
