"""Compare what is proved of boxes of poses of machines with cranks and slides with poses in them.

Random boxes about the home poses of machines are judged; each proved verdict must hold at the
corners of its box and at random poses in it, by inverse kinematics of its own
(`tools.verify.driven_machines`). Volumes of positions and of mixed sections are bounded, and their
bounds must enclose a Monte Carlo estimate. The record is
``data/verification/driven-workspaces.csv``.
"""

from __future__ import annotations

import sys
import time
from dataclasses import asdict, dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.motion.workspace.box_division import workspace
from gspcli.motion.workspace.pose_boxes import PoseBoxes, places
from tools.recording import ROOT, add_workers, csv_text, parser, sampled, workers_of
from tools.verify.campaigns import conclude
from tools.verify.driven_machines import Machine, PlaneGeometry, machines

RECORD = ROOT / "data" / "verification" / "driven-workspaces.csv"
#: Halvings of the box about home, random boxes of each, and poses of each box.
LEVELS, BOXES, POSES = (2, 3, 4, 5, 6), 3500, 64
#: The gap of the bounds of volumes, and the poses of estimates of them.
GAP, SAMPLES = 0.05, 200_000
SECTIONS = {"positions": ("x", "y", "z"), "section": ("z", "rx", "ry")}


@dataclass(frozen=True)
class Row:
    """What was proved of the boxes of a level, or of a volume, of one machine."""

    machine: str
    subject: str
    boxes: int
    inside: int
    outside: int
    open: int
    wrong: int
    lower: float | None = None
    upper: float | None = None
    estimate: float | None = None


def examine(key: tuple[str, int | str]) -> Row:
    """Judge boxes of one level of one machine, or bound a volume."""
    name, subject = key
    machine = machines()[name]()
    if isinstance(subject, str):
        return volume(machine, name, subject)
    return judged(machine, name, subject)


def judged(machine: Machine, name: str, level: int, count: int = BOXES) -> Row:
    """Judge random boxes of the grid of a level, and all of them again by their poses.

    Half of the boxes are judged as the parts of larger ones, as they are when a volume is bounded.
    """
    rng = np.random.default_rng((SEED, level, len(name)))
    boxes = PoseBoxes(machine.instance, machine.R, machine.T)
    half = np.repeat(machine.room, 3) * rng.uniform(0.3, 1.2, 6)
    # Some boxes without turns, as those of positions are.
    free = [0, 1, 2] if level % 2 else list(range(6))
    bounds = np.stack((boxes.home, boxes.home), axis=1)
    bounds[free] += np.stack((-half, half), axis=1)[free]
    step = np.zeros(6)
    step[free] = (bounds[:, 1] - bounds[:, 0])[free] / 2.0**level
    truth, rows = PlaneGeometry(machine), []
    for split in (False, True):
        parts = len(free) if split else 0
        keys = _keys(
            rng.integers(0, 2 ** (level - split), (-(-count // 2 ** (parts + 1)), len(free)))
        )
        left = np.full(len(keys), boxes.conditions)
        found = boxes.judge(bounds, free, level, keys, left, split=split)
        if split:
            bits = np.array(list(product((0, 1), repeat=len(free))))
            keys = _keys((2 * places(keys, len(free))[:, None] + bits).reshape(-1, len(free)))
        verdict = np.where(np.isin(keys, found.inside), 1, np.isin(keys, found.open) - 1)
        low = np.repeat(bounds[None, :, 0], len(keys), axis=0)
        low[:, free] += places(keys, len(free)) * step[free]
        wrong = 0
        for _ in range(POSES):
            part = (
                rng.choice([0.0, 1.0], (len(keys), 6))
                if rng.uniform() < 0.5
                else rng.uniform(size=(len(keys), 6))
            )
            reached = truth.reached(*boxes.poses(low + part * step))
            wrong += int((((verdict == 1) & ~reached) | ((verdict == -1) & reached)).sum())
        rows.append([len(keys), *(int((verdict == which).sum()) for which in (1, -1, 0)), wrong])
    return Row(name, f"level {level}", *np.sum(rows, axis=0).tolist())


def _keys(found: NDArray[np.int64]) -> NDArray[np.uint64]:
    """Return the keys of places in the grid, each once, ``(n, d) -> (m,)``."""
    shifts = np.arange(found.shape[1], dtype=np.uint64) * np.uint64(64 // found.shape[1])
    return np.unique((found.astype(np.uint64) << shifts).sum(axis=1, dtype=np.uint64))


def volume(machine: Machine, name: str, subject: str) -> Row:
    """Bound the volume of a section, and estimate it."""
    free = SECTIONS[subject]
    size = machine.room[0] * 1.5
    angle = np.degrees(machine.room[1]) * 1.5
    home = dict(zip("xyz", machine.T.tolist(), strict=True))
    within = {
        name: (home[name] - size, home[name] + size) if name in home else (-angle, angle)
        for name in free
    }
    found = workspace(
        machine.instance, machine.R, machine.T, free=free, within=within, tolerance=GAP
    )
    low, high = found.volume
    rng = np.random.default_rng(SEED)
    ends = np.array([within[name] for name in free])
    points = rng.uniform(ends[:, 0], ends[:, 1], (SAMPLES, len(free)))
    boxes = found.boxes
    parameters = np.tile(boxes.home, (SAMPLES, 1))
    parameters[
        :, ["xyzrxryrz".index(n) if len(n) == 1 else 3 + "xyz".index(n[1]) for n in free]
    ] = points * found.units
    share = PlaneGeometry(machine).reached(*boxes.poses(parameters)).mean()
    whole = float(np.prod(ends[:, 1] - ends[:, 0]))
    spread = 4 * whole * np.sqrt(share * (1 - share) / SAMPLES)
    estimate = whole * float(share)
    wrong = int(not low - spread <= estimate <= high + spread) + int(found.gap > GAP)
    counts = len(found.inner_keys), found.judged - len(found.inner_keys) - len(found.open_keys)
    numbers = (float(f"{x:.4g}") for x in (low, high, estimate))
    return Row(name, subject, found.judged, *counts, len(found.open_keys), wrong, *numbers)


def main() -> int:
    """Judge, compare or write; return the exit code."""
    options = parser(__doc__, sample=True)
    add_workers(options)
    arguments = options.parse_args()
    subjects: list[int | str] = [*LEVELS, *SECTIONS]
    keys = [(name, subject) for name in machines() for subject in subjects]
    keys = sampled(keys, arguments.sample if arguments.check else None)
    started = time.process_time()
    rows = list(workers_of(arguments).in_order(examine, keys))
    wrong = [f"{row}: wrong" for row in rows if row.wrong]
    boxes = sum(row.boxes for row in rows if row.estimate is None)
    volumes = sum(row.estimate is not None for row in rows)
    summary = f"0 wrong of {boxes} boxes and {volumes} volumes"
    print(f"{time.process_time() - started:.0f} s of processor time")
    return conclude(
        RECORD, csv_text(list(map(asdict, rows))), wrong, summary, check=arguments.check
    )


if __name__ == "__main__":
    sys.exit(main())
