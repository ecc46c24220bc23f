"""Check proved paths against samples, and which modes they join; record it.

    python -m tools.verify.paths [--segments 100000] [--samples 10000] [--only WHAT ...] [--jobs 2]
        [--work FOLDER] [--check]

What must hold:

- Segments: of random straight ways in position and angles on machines of all kinds, each that is
  proved regular keeps the sign of the determinant at all samples. The determinant is that of
  `tools.verify.sampled_signs`, which shares nothing with the proof.
- Groups: without ranges all modes of one class are joined, or proved apart, within 10 seconds: on
  all shipped hexapods with legs, on ten random ones and on types whose determinant factors. With
  ranges the groups are those known, within 30 seconds, along values and along poses.
- Lengths: of paths between modes of one group at most one of a machine is longer than three times
  the straight line.
- Motors: each path along poses of a machine with cranks or slides, to random poses near home, is
  proved again row by row, as `gsp track --along poses --require range` does.
- Homes: from 200 random poses within the limits of each of four machines 95 of 100 ways home are
  straight, and all others are found on a map.

The record is ``data/verification/paths.csv``. Times are said, not recorded. Interrupted, the same
command takes the segments up again, all machines alike: `--segments` may be raised later.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.catalogue.names import parse_type
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import has_limits, within_limits
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import mode_groups
from gspcli.motion.paths.classes import Classes
from gspcli.motion.paths.pose_tracks import pose_track
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.smoothing import LONG
from gspcli.motion.poses.inverse_kinematics import values_at
from tools.recording import ROOT, add_workers, csv_text, parser, workers_of
from tools.verify.campaigns import TaskRow, add_work, conclude, results
from tools.verify.sampled_signs import determinants

RECORD = ROOT / "data" / "verification" / "paths.csv"
Array = NDArray[np.float64]

#: Hexapods with legs, without their ranges.
LEGS = (
    *("platform-6-6", "dietmaier", "platform-5-5", "platform-6-3", "platform-6-4", "planar-6-6"),
    *("octahedral-3-3", "nano-hexapod", "rubin-camera", "rubin-m2", "apo-tertiary"),
    *("linuxcnc-hexapod", "simscape-hexapod", "simmechanics-hexapod", "workspace-study"),
    "workspace-study-cones",
)
#: Types whose determinant factors.
FACTORS = (
    *("surfaces-sss", "surfaces-ssc", "surfaces-psc", "surfaces-scc", "surfaces-ccc"),
    *("surfaces-ppc", "surfaces-pps", "surfaces-pss", "surfaces-pcc", "sdss-primary"),
    "example-6.8",
)
#: With ranges: how many groups there are.
RANGED = {
    "workspace-study": 2,
    "rubin-camera": 4,
    "rubin-m2": 2,
    "apo-tertiary": 8,
    "sdss-primary": 8,
}
RANDOM = 10
#: The parts of the record.
WHAT = (
    *("groups", "groups with ranges", "groups along poses", "homes", "lengths", "motors"),
    "segments",
)
#: Machines for segments: all ten kinds.
SEGMENTS = (*LEGS, *FACTORS, "six-planes", "fixture-3-2-1", "figure-2", "figure-4")
#: Machines for lengths of paths, and how many pairs of modes each.
LENGTHS = ("workspace-study", "nano-hexapod", "octahedral-3-3", "surfaces-sss", "dietmaier")
_PAIRS = 6
#: Machines with cranks or slides, and whether their platforms turn; how many goals each.
MOTORS = {
    "t-top-head": True,
    "reachy-mini-head": True,
    "hexaglide": True,
    "modified-paradex": True,
    "delta": False,
    "three-prs": False,
}
_GOALS = 10
HOMES = ("workspace-study", "workspace-study-cones", "rubin-camera", "rubin-m2")
#: What the answers about segments come from.
SOURCES = (
    "native",
    "gspcli/motion/workspace",
    "gspcli/motion/paths/pose_ways.py",
    "tools/verify/sampled_signs.py",
)
#: Segments and homes that one worker does.
_CHUNK, _HOMES = 50, 25
#: Seconds that are given to the groups of a machine.
_SECONDS = {"groups": 10.0, "groups with ranges": 30.0, "groups along poses": 30.0}
#: From this many poses ways home are planned, and this part of them must be straight.
_POSES, _STRAIGHT = 200, 0.95


@dataclass(frozen=True)
class Row:
    """What was found of one machine."""

    what: str
    machine: str
    tried: int
    found: int
    wrong: int


def machine(name: str, *, limits: bool) -> Instance:
    """Return a machine, random if its name is a number, perhaps without ranges and cones."""
    if name.isdecimal():
        draw = np.random.default_rng((SEED, int(name)))
        return random_instance(parse_type("6PP"), draw)[0]
    instance = gspcli.example(name)
    if limits or not has_limits(instance):
        return instance
    rows = []
    for row in instance.constraints:
        points = {
            body: replace(point, cone=None)
            for body in ("platform", "base")
            if getattr(point := getattr(row, body), "cone", None) is not None
        }
        rows.append(replace(row, limits=None, **points))
    return replace(instance, constraints=tuple(rows))


def groups(what: str, name: str) -> Row:
    """Group the modes of a machine; `wrong` counts the pairs of groups that are undecided."""
    instance = machine(name, limits=what != "groups")
    along = "poses" if what == "groups along poses" else None
    found = mode_groups(instance, along=along, time=_SECONDS[what])
    return Row(what, name, len(found.modes), len(found.groups), len(found.undecided))


@cache
def _for_segments(name: str) -> tuple[PoseWays, Array]:
    """Return the ways of a machine without limits, and the parameters of its modes."""
    instance = machine(name, limits=False)
    ways = PoseWays(instance, limits=False)
    solved = gspcli.solve(instance)
    R, T = (part[solved.real].real for part in (solved.R, solved.T))
    return ways, ways.parameters(R, T)


def segments(name: str, chunk: int, count: int, samples: int) -> tuple[int, int]:
    """Return how many random ways are proved, and how many of them are wrong."""
    ways, modes = _for_segments(name)
    platform = Arrangement.of(ways.instance)
    draw = np.random.default_rng((SEED, chunk, sum(map(ord, name))))
    parts = np.linspace(0, 1, samples)[:, None]
    proved = wrong = 0
    for _ in range(count):
        begin = modes[draw.integers(len(modes))]
        begin = begin + draw.normal(size=6) * ways.sizes * 10.0 ** -draw.integers(0, 4)
        end = begin + draw.normal(size=6) * ways.sizes * 10.0 ** -draw.integers(0, 3)
        if ways.prove(begin, end).sign:
            proved += 1
            between = begin + (end - begin) * parts
            signs = np.sign(determinants(platform, ways.pivot, between))
            wrong += bool((signs != signs[0]).any() or not signs[0])
    return proved, wrong


@dataclass
class Chunk(TaskRow):
    """What was found of some segments of one machine."""

    name: str
    tried: int
    proved: int
    wrong: int


def _chunk(samples: int, task: str) -> Chunk:
    """Try the segments of a task, which is the name of a machine and the number of the chunk."""
    name, number = task.rsplit(":", 1)
    proved, wrong = segments(name, int(number), _CHUNK, samples)
    return Chunk(task, _CHUNK, proved, wrong)


def segment_rows(arguments: argparse.Namespace) -> list[Row]:
    """Return what all segments of each machine have given; the work file has what is done."""
    chunks = -(-arguments.segments // (len(SEGMENTS) * _CHUNK))
    # All machines come in turns, so that what is done of them is the same.
    tasks = [f"{name}:{chunk}" for chunk in range(chunks) for name in SEGMENTS]
    done = results(
        tasks,
        partial(_chunk, arguments.samples),
        Chunk.of_entry,
        arguments,
        name=f"segments-{arguments.samples}",
        label="segments",
        sources=SOURCES,
    )
    found = {name: Row("segments", name, 0, 0, 0) for name in SEGMENTS}
    for one in done:
        name = one.name.rsplit(":", 1)[0]
        before = found[name]
        found[name] = Row(
            "segments",
            name,
            before.tried + one.tried,
            before.found + one.proved,
            before.wrong + one.wrong,
        )
    return list(found.values())


def homes(name: str, chunk: int) -> tuple[int, int]:
    """Return from how many random poses the way home is straight, and how many have no way."""
    instance = gspcli.example(name)
    ways = PoseWays(instance, limits=False)
    solved = gspcli.solve(instance)
    assert solved.home is not None
    home = ways.parameters(solved.home.R, solved.home.T)
    classes = Classes(instance, ways)
    signs = classes.of(solved.home.R, solved.home.T)
    draw = np.random.default_rng((SEED, chunk))
    straight = missing = done = 0
    while done < _HOMES:
        # Ranges are as short as a hundredth of some machines.
        width = 10.0 ** -draw.uniform(0, 2.5)
        one = home + draw.uniform(-1, 1, size=6) * ways.sizes * width
        R, T = ways.poses(one)
        kept = within_limits(instance, values_at(instance, R, T), R, T)
        if not kept or classes.of(R, T).signs != signs.signs:
            continue
        done += 1
        found = gspcli.path(instance, (R, T), "home")
        straight += len(found.parts) == 1
        missing += found.verdict != "proved"
    return straight, missing


def lengths(name: str) -> tuple[int, int, int]:
    """Return how many paths between modes are tried, how many are short, how many not proved."""
    instance = gspcli.example(name)
    found = mode_groups(instance).groups.values()
    pairs = [pair for group in found for pair in pairwise(group)][:_PAIRS]
    planned = [gspcli.path(instance, *pair) for pair in pairs]
    short = sum(len(one.T) > 0 and one.length <= LONG * one.straight_length for one in planned)
    return len(pairs), short, sum(one.verdict != "proved" for one in planned)


def motors(name: str) -> tuple[int, int, int]:
    """Return how many goals are tried, how many paths found, how many not proved again."""
    solved = gspcli.solve(gspcli.example(name))
    instance = solved.instance
    home = 0 if solved.home is None else solved.home.number - 1
    R, T = solved.R[home].real, solved.T[home].real
    size = Arrangement.of(instance).length
    draw = np.random.default_rng(SEED)
    found = wrong = 0
    for _ in range(_GOALS):
        turn, shift = draw.normal(size=(2, 3)) * 10.0 ** -draw.uniform(1, 3)
        # The platform of the tripod moves along its axis only.
        shift = shift if name != "three-prs" else shift * [0, 0, 1]
        turned = rotation_from_vector(turn) @ R if MOTORS[name] else R
        goal = turned, T + size * shift
        way = gspcli.path(instance, (R, T), goal, along="poses", pivot=[0, 0, 0], time=0)
        if way.verdict != "proved":
            continue
        found += 1
        again = pose_track(
            instance, instance, PoseFrame(), way.t, way.R, way.T, sequence="ZYX", mode=1
        )
        wrong += bool(again.track.ends or again.limits)
    return _GOALS, found, wrong


def _work(job: tuple[str, str, int]) -> tuple[Row, float]:
    what, name, chunk = job
    begin = time.process_time()
    if what == "homes":
        straight, missing = homes(name, chunk)
        return Row(what, name, _HOMES, straight, missing), time.process_time() - begin
    if what == "motors":
        return Row(what, name, *motors(name)), time.process_time() - begin
    if what == "lengths":
        return Row(what, name, *lengths(name)), time.process_time() - begin
    return groups(what, name), time.process_time() - begin


def _together(rows: list[tuple[Row, float]]) -> list[tuple[Row, float]]:
    """Add the rows of one machine."""
    found: dict[tuple[str, str], tuple[Row, float]] = {}
    for row, seconds in rows:
        key = row.what, row.machine
        if key in found:
            before, more = found[key]
            row = Row(
                *key,
                before.tried + row.tried,
                before.found + row.found,
                before.wrong + row.wrong,
            )
            seconds += more
        found[key] = row, seconds
    return list(found.values())


def _wrong(row: Row) -> str:
    """Return what does not hold, or nothing."""
    if row.wrong:
        return f"{row.what} of {row.machine}: {row.wrong} wrong"
    ranged = row.what in ("groups with ranges", "groups along poses")
    if ranged and row.found != RANGED[row.machine]:
        return f"{row.machine}: found {row.found} groups, expected {RANGED[row.machine]}"
    if row.what == "lengths" and row.found < row.tried - 1:
        return f"{row.machine}: {row.tried - row.found} of {row.tried} paths are long"
    if row.what == "homes" and row.found < _STRAIGHT * row.tried:
        return f"{row.machine}: {row.found} of {row.tried} ways home are straight"
    return ""


def main() -> int:
    """Measure, compare or write; return the exit code."""
    options = parser(__doc__)
    add_work(options)
    options.add_argument("--segments", type=int, default=100_000, help="how many random ways")
    options.add_argument("--samples", type=int, default=10_000, help="samples of each proved way")
    options.add_argument(
        "--only", action="append", choices=WHAT, help="which part; may be repeated"
    )
    add_workers(options)
    arguments = options.parse_args()
    jobs = [("groups", name, 0) for name in (*LEGS, *FACTORS)]
    jobs += [("groups", str(k), 0) for k in range(RANDOM)]
    jobs += [(what, name, 0) for what in WHAT[1:3] for name in RANGED]
    jobs += [("homes", name, k) for name in HOMES for k in range(_POSES // _HOMES)]
    jobs += [("lengths", name, 0) for name in LENGTHS]
    jobs += [("motors", name, 0) for name in MOTORS]
    wanted = arguments.only or WHAT
    jobs = [job for job in jobs if job[0] in wanted]
    done = _together(list(workers_of(arguments).in_order(_work, jobs)))
    for row, seconds in done:
        print(f"{row.what} {row.machine}: {row.found} of {row.tried}, {seconds:.2f} s")
    rows = [row for row, _ in done]
    if "segments" in wanted:
        rows += segment_rows(arguments)
    wrong = list(filter(None, map(_wrong, rows)))
    parts = []
    for what in dict.fromkeys(row.what for row in rows):
        these = [row for row in rows if row.what == what]
        sums = [sum(getattr(row, key) for row in these) for key in ("tried", "found", "wrong")]
        parts.append(f"{what}: {sums[0]} tried, {sums[1]} found, {sums[2]} wrong")
    recorded = [asdict(row) for row in rows]
    for one in recorded:
        if one["what"] == "segments":
            # Which ways are proved can depend on last digits.
            one["found"] = round(one["found"], -2)
    if arguments.only and not arguments.check:
        # The other rows are unchanged.
        text = RECORD.read_text(encoding="utf-8").splitlines()
        new = {line.rsplit(",", 3)[0]: line for line in csv_text(recorded).splitlines()[1:]}
        kept = [line for line in text if line.rsplit(",", 3)[0] not in new]
        return conclude(
            RECORD, "\n".join([*kept, *new.values()]) + "\n", wrong, "; ".join(parts), check=False
        )
    return conclude(RECORD, csv_text(recorded), wrong, "; ".join(parts), check=arguments.check)


if __name__ == "__main__":
    sys.exit(main())
