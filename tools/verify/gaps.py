"""Check gaps that are proved on straight ways of poses against samples; record it.

    python -m tools.verify.gaps [--ways 500] [--samples 680] [--check]

On three machines with thick legs random straight ways in position and angles are drawn, and what is
proved of the least gap between two legs is compared with samples. Their distances are computed by
cases, from each end to the other leg and between both lines, which the proofs do not use. No sample
may be below what is proved. The record is ``data/verification/gaps.csv``. The same is done on three
machines with cranks or slides, on a part of the ways along poses and along the numbers of their
drives: ``data/verification/driven-gaps.csv``.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.shapes import Shapes
from gspcli.motion import Track, track
from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.gaps_between import least_gaps
from gspcli.motion.paths.motors import Motors
from gspcli.motion.paths.pose_tracks import pose_track
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.track_bounds import worst_between
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.solver import solve
from gspcli.spec.shipped import example
from tools.recording import ROOT, csv_text, parser, save

Array = NDArray[np.float64]

#: Diameters of legs.
MACHINES = {"workspace-study": 20.0, "rubin-camera": 0.09, "apo-tertiary": 0.6}
#: Machines with motors, and their rods' length by their diameter.
DRIVEN = {"reachy-mini-head": 25.0, "t-top-head": 25.0, "hexaglide": 60.0}
RECORD = ROOT / "data" / "verification" / "gaps.csv"
DRIVEN_RECORD = ROOT / "data" / "verification" / "driven-gaps.csv"


def distances(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Return the distances of segments a b and c d by cases, ``(..., 3) -> (...)``."""

    def to_segment(p: Array, u: Array, v: Array) -> Array:
        way = v - u
        along = ((p - u) * way).sum(-1) / (way**2).sum(-1)
        return np.asarray(np.linalg.norm(p - u - np.clip(along, 0, 1)[..., None] * way, axis=-1))

    found = [to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)]
    ends = np.min(found, axis=0)
    u, v = b - a, d - c
    n = np.cross(u, v)
    with np.errstate(all="ignore"):
        square = (n**2).sum(-1)
        s = (np.cross(c - a, v) * n).sum(-1) / square
        t = (np.cross(c - a, u) * n).sum(-1) / square
        inside = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
        lines = np.abs(((c - a) * n).sum(-1)) / np.sqrt(square)
    return np.asarray(np.where(inside, np.minimum(ends, lines), ends))


def checked_drives(name: str, along: str, ways: int, samples: int) -> dict[str, object]:
    """Return the row of a machine with motors that move points."""
    solved = solve(example(name))
    assert solved.home is not None
    R0, T0 = solved.home.R, solved.home.T
    drives = Drives.of(solved.instance)
    size = float(drives.rods.max())
    diameter = size / DRIVEN[name]
    instance = replace(solved.instance, shapes=Shapes(diameter))
    motors, draw = Motors(instance), np.random.default_rng(SEED)
    stated = Arrangement.of(instance)
    i, j = _compared(stated)
    done = proved = wrong = 0
    while done < ways:
        R = np.stack([rotation_from_vector(0.05 * draw.normal(size=3)) @ R0 for _ in range(2)])
        T = T0 + 0.05 * size * draw.normal(size=(2, 3))
        q = motors.numbers(R, T)
        if np.isnan(q).any():
            continue
        way = _poses if along == "poses" else _drives
        coarse, straight, R, T, q = way(motors, R, T, samples)
        if coarse.ends:
            continue
        b, arm, _ = drives.ends(R, T, q)
        y, x = arm + T[:, None], b
        least = float(distances(y[:, i], x[:, i], y[:, j], x[:, j]).min()) - diameter
        wanted = least - 1e-3 * size
        between = worst_between(coarse, "gap", wanted, straight)
        bound = wanted if between is None else between.bound
        done += 1
        proved += between is None
        tight = worst_between(coarse, "gap", least + 1e-9 * size, straight)
        wrong += tight is None or bound > least + 1e-9 * size or tight.bound > least + 1e-9 * size
    return {
        "machine": name,
        "along": along,
        "ways": ways,
        "samples": ways * samples,
        "proved": proved,
        "contradictions": wrong,
    }


def _poses(
    motors: Motors, R: Array, T: Array, samples: int
) -> tuple[Track, PoseWays, Array, Array, Array]:
    """Return a straight way of poses with samples of its poses and drives."""
    machine, times = motors.instance, np.arange(2.0)
    found = pose_track(machine, machine, PoseFrame(), times, R, T, sequence="ZYX", mode=1)
    first, last = found.ways.continued(R, T)
    R, T = found.ways.poses(first + (last - first) * np.linspace(0, 1, samples)[:, None])
    return found.track, found.ways, R, T, motors.numbers(R, T)


def _drives(
    motors: Motors, R: Array, T: Array, samples: int
) -> tuple[Track, None, Array, Array, Array]:
    """Return a straight way of drives with samples; each is a row of another track."""
    drives, values = motors.drives, motors.values(R, T)
    part, ends = np.linspace(0, 1, samples)[:, None], motors.numbers(R, T)

    def followed(rows: Array, q: Array) -> Track:
        columns = {name: drives.readings(q)[:, k] for k, name in enumerate(drives.names)}
        return track(motors.instance, rows, coordinates=columns, near=(R[0], T[0]))

    q = ends[0] + (ends[1] - ends[0]) * part
    fine = followed(values[0] + (values[1] - values[0]) * part, q)
    return followed(values, ends), None, fine.R[0], fine.T[0], q


def _compared(a: Arrangement) -> tuple[Array, Array]:
    """Return the pairs of legs that share no joint."""
    i, j = np.triu_indices(6, 1)
    kept = [
        (p, q)
        for p, q in zip(i.tolist(), j.tolist(), strict=True)
        if not (np.array_equal(a.y[p], a.y[q]) or np.array_equal(a.x[p], a.x[q]))
    ]
    first, second = np.array(kept).T
    return first, second


def checked(name: str, ways: int, samples: int) -> dict[str, object]:
    """Return the row of a machine."""
    diameter = MACHINES[name]
    instance = replace(example(name), shapes=Shapes(diameter))
    a, draw = Arrangement.of(instance), np.random.default_rng(SEED)
    straight = PoseWays(instance, limits=False)
    home = a.base_centre + np.array([0.0, 0.0, 0.9 * a.length])
    parameters = np.concatenate((home, np.zeros(3))) + draw.uniform(-0.3, 0.3, (ways, 2, 6)) * (
        straight.sizes
    )
    i, j = _compared(a)
    wrong = proved = 0
    for pair in parameters:
        part = np.linspace(0, 1, samples)[:, None]
        R, T = straight.poses(pair[0] + (pair[1] - pair[0]) * part)
        y = a.y @ np.swapaxes(R, -1, -2) + T[:, None]
        x = np.broadcast_to(a.x, y.shape)
        least = float(distances(y[:, i], x[:, i], y[:, j], x[:, j]).min()) - diameter
        R, T = straight.poses(pair)
        rows = PathRows(straight, values_at(instance, R, T), R, T, pair)
        # What is asked for is near to what is true, so that proofs are tight.
        bound = float(least_gaps(rows, least - 1e-3 * a.length)[1][0])
        wrong += bound > least + 1e-9 * a.length
        proved += bound >= least - 1e-3 * a.length
    return {
        "machine": name,
        "ways": ways,
        "samples": ways * samples,
        "proved": proved,
        "contradictions": wrong,
    }


def main() -> int:
    """Check all machines and record them, or compare with the record."""
    options = parser(__doc__)
    options.add_argument("--ways", type=int, default=500, help="straight ways of each machine")
    options.add_argument("--samples", type=int, default=680, help="poses of each way")
    arguments = options.parse_args()
    rows = [checked(name, arguments.ways, arguments.samples) for name in MACHINES]
    drawn = {"poses": arguments.ways // 25, "drives": arguments.ways // 250}
    driven = [
        checked_drives(name, along, ways, arguments.samples)
        for name in DRIVEN
        for along, ways in drawn.items()
    ]
    for row in [*rows, *driven]:
        print(row, file=sys.stderr)
    if any(row["contradictions"] for row in [*rows, *driven]):
        return 1
    content = {RECORD: csv_text(rows), DRIVEN_RECORD: csv_text(driven)}
    return save(content, check=arguments.check, confirmed="gaps on ways are confirmed")


if __name__ == "__main__":
    sys.exit(main())
