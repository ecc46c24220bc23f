"""Verify that followed modes never jump, on random trajectories of many types, and record it.

    python -m tools.verify.tracks [--types 250] [--each 40] [--jobs 2] [--work FOLDER]
        [--check [--sample N]]

For each of some types, random platforms are moved from the values of a random pose to those of
another one nearby, in one step, and all real modes are followed with proof (`gspcli.motion.track`).
At both ends all real poses are found by `solve`, which does not follow modes. What must hold:

- each mode that arrives is one of the poses at the end, and no two are the same;
- followed back from there, it arrives at the pose where it began (or following stops without a
  proof of anything: `back_undecided`);
- each mode that does not arrive ends in a proved fold, or following stopped without a proof of
  anything (`undecided`: parallel lines of a DLL, poses far away, poses nearly singular);
- each pose at the end that no mode has reached is followed back to a proved fold, or undecided.

What does not hold is a `jump` or `unexplained`, and the exit code is 1. The record in
``data/verification/tracks.csv`` has a line for each type; it does not depend on ``--jobs``. The
loop in ``data/trajectories/`` is followed, too: it must lead its mode to another one, with proof.
Interrupted, the same command takes the work up again.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from functools import partial

import numpy as np

import gspcli
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import GspType, all_types, type_by_number
from gspcli.defaults import SEED
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import MovingPlatform, PoseFormat, Track, measure, read_values, track
from gspcli.motion.following.branch_follower import Stop
from tools.recording import ROOT, csv_text, sampled
from tools.verify.campaigns import TaskRow, conclude, exit_after, options, results

RECORD = ROOT / "data" / "verification" / "tracks.csv"
TRAJECTORIES = ROOT / "data" / "trajectories"
#: Types with more poses on one side take too long to solve at both ends.
MOST = 64
#: Study points of norm one at the same pose differ by less.
SAME = 1e-7
#: Standard deviations of the motion: radians, and lengths of platforms of size about one.
TURN, SHIFT = 0.3, 0.3


@dataclass
class Row(TaskRow):
    """What happened to the modes of one type."""

    number: int
    id: str
    trajectories: int = 0
    modes: int = 0
    arrived: int = 0
    folds: int = 0
    undecided: int = 0
    born_in_folds: int = 0
    born_undecided: int = 0
    back_undecided: int = 0
    jumps: int = 0
    unexplained: int = 0

    @property
    def problems(self) -> int:
        """How much does not hold."""
        return self.jumps + self.unexplained


def chosen(count: int) -> list[int]:
    """Return the numbers of types evenly spread over those that are quick to solve."""
    quick = [t.number for t in all_types() if generic_counts(t).one_sided <= MOST]
    return [quick[k * len(quick) // count] for k in range(min(count, len(quick)))]


def examine(each: int, number: int) -> Row:
    """Follow the modes of random platforms of a type along random trajectories."""
    gsp_type = type_by_number(number)
    row = Row(number, gsp_type.id)
    for k in range(each):
        _examine_one(row, gsp_type, np.random.default_rng((SEED, number, k)))
    return row


def _examine_one(row: Row, gsp_type: GspType, rng: np.random.Generator) -> None:
    instance, (R, T) = random_instance(gsp_type, rng)
    ends = [
        (R, T),
        (rotation_from_vector(TURN * rng.normal(size=3)) @ R, T + SHIFT * rng.normal(size=3)),
    ]
    values = np.stack([measure(instance, *pose) for pose in ends])
    found = track(instance, values, everything=True)
    row.trajectories += 1
    from_start = ~np.isnan(found.T[:, 0, 0])
    at_end = ~np.isnan(found.T[:, -1, 0])
    row.modes += int(from_start.sum())
    row.arrived += int((from_start & at_end).sum())
    _examine_ends(row, found, from_start & at_end)
    for event in found.events:
        if event.begins:
            row.born_in_folds += event.kind == "fold"
            row.born_undecided += event.kind == "undecided"
        else:
            row.folds += event.kind == "fold"
            row.undecided += event.kind == "undecided"
    ended = {event.mode for event in found.ends}
    began = {event.mode for event in found.events if event.begins}
    for m, mode in enumerate(found.modes.tolist()):
        row.unexplained += bool(from_start[m] and not at_end[m] and mode not in ended)
        row.unexplained += bool(at_end[m] and not from_start[m] and mode not in began)


def _examine_ends(row: Row, found: Track, through: np.ndarray) -> None:
    """Count the modes that are not what they should be at the end, or when followed back."""
    platform = MovingPlatform(found.instance)
    start, end = (platform.points(found.R[through, k], found.T[through, k]) for k in (0, -1))
    if not len(end):
        return
    assert found.poses_at_end is not None
    every = platform.points(*found.poses_at_end)
    hits = distances(end, every) < SAME
    row.jumps += int((hits.sum(axis=1) != 1).sum()) + int((hits.sum(axis=0) > 1).sum())
    back = platform.follow(
        platform.internal(found.values[::-1])[None], np.zeros(len(end), np.int64), end
    )
    arrived = back.stop == Stop.END
    apart = np.diagonal(distances(back.points[arrived, -1], start[arrived]))
    row.jumps += int((apart > SAME).sum())
    row.back_undecided += int((~arrived).sum())


def distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distances of Study points, which are known up to sign, shape (n, m)."""
    near = np.linalg.norm(a[:, None] - b, axis=2)
    return np.asarray(np.minimum(near, np.linalg.norm(a[:, None] + b, axis=2)))


def loop_problems() -> list[str]:
    """Return what does not hold of the loop that changes the mode: mode 2 becomes mode 1."""
    instance = gspcli.load(TRAJECTORIES / "mode-change.yaml")
    text = (TRAJECTORIES / "mode-change.csv").read_text(encoding="utf-8")
    values = read_values(text, "mode-change.csv", instance, PoseFormat()).values
    start, loop = track(instance, values[:1]), track(instance, values, modes=[2])
    if not np.array_equal(values[0], values[-1]) or loop.events:
        return ["mode-change: the loop is not closed, or its mode ends"]
    platform = MovingPlatform(instance)
    apart = distances(
        platform.points(loop.R[:, -1], loop.T[:, -1]), platform.points(start.R[:, 0], start.T[:, 0])
    )[0]
    return [] if apart[0] < SAME and apart[1] > SAME else ["mode-change: mode 2 is not mode 1"]


def main() -> int:
    """Follow, compare or write; return the exit code."""
    parser = options(__doc__)
    parser.add_argument("--types", type=int, default=250, help="how many types")
    parser.add_argument("--each", type=int, default=40, help="trajectories of each")
    arguments = parser.parse_args()
    numbers = sampled(chosen(arguments.types), arguments.sample if arguments.check else None)
    rows = results(
        sorted(numbers),
        partial(examine, arguments.each),
        Row.of_entry,
        arguments,
        name=f"tracks-{arguments.each}",
        label="following modes",
    )
    total = {field.name: sum(getattr(row, field.name) for row in rows) for field in fields(Row)[2:]}
    summary = ", ".join(f"{value} {name.replace('_', ' ')}" for name, value in total.items())
    wrong = [f"{row.id}: {row.problems} problems" for row in rows if row.problems]
    wrong += loop_problems()
    text, summary = csv_text(list(map(asdict, rows))), f"{len(rows)} types: {summary}"
    return conclude(RECORD, text, wrong, summary, check=arguments.check)


if __name__ == "__main__":
    exit_after(main)
