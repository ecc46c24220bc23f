"""Check gaps that are proved on straight ways of poses against samples; record it.

    python -m tools.verify.gaps [--ways 500] [--samples 680] [--check]

On three machines with thick legs random straight ways in position and angles are drawn, and what is
proved of the least gap between two legs is compared with samples. Their distances are computed by
cases, from each end to the other leg and between both lines, which the proofs do not use. No sample
may be below what is proved. The record is ``data/verification/gaps.csv``.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.shapes import Shapes
from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.gaps_between import least_gaps
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.spec.shipped import example
from tools.recording import ROOT, csv_text, parser, save

Array = NDArray[np.float64]

#: Diameters of legs.
MACHINES = {"workspace-study": 20.0, "rubin-camera": 0.09, "apo-tertiary": 0.6}
RECORD = ROOT / "data" / "verification" / "gaps.csv"


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
    i, j = np.triu_indices(6, 1)
    kept = [
        (p, q)
        for p, q in zip(i.tolist(), j.tolist(), strict=True)
        if not (np.array_equal(a.y[p], a.y[q]) or np.array_equal(a.x[p], a.x[q]))
    ]
    i, j = np.array(kept).T
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
    for row in rows:
        print(row, file=sys.stderr)
    if any(row["contradictions"] for row in rows):
        return 1
    content = csv_text(rows)
    return save({RECORD: content}, check=arguments.check, confirmed="gaps on ways are confirmed")


if __name__ == "__main__":
    sys.exit(main())
