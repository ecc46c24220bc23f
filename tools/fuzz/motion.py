"""Attack `gsp track` with random trajectories, and check what it says by other ways.

    python -m tools.fuzz.motion [--count 50] [--seed N] [--most 32]

Each attack is a random platform of a random type (of at most ``--most`` poses on one side) and a
random CSV file. Its rows are values measured at random poses nearby. They are unchanged, or changed
in one way. A row is repeated, the rows return to the first, or go there and back. One row is at a
fold that was found (to its last digit), a coordinate moves, ``--steps`` is larger, or a cell is
spoilt. Both go through the command line, in JSON and in CSV. What must hold:

- a spoilt cell is reported with its line and column, and exit code 2. Otherwise the exit code is 4
  if modes end or do not account for the poses at the last row, and 0 if not;
- CSV and JSON have the same numbers;
- each mode has a pose at each row from its first to its last, and at no other. A mode that begins
  after the first row, or ends before the last, has one event there;
- the poses at each row are different poses of the complete set that `solve` finds there; at the
  first and last row they are the whole set (rows with nearly singular poses are omitted);
- backwards, modes that reach the other end return to their start, and folds are at the same t.

Rows of which `solve` says that they have infinitely many poses, or that not all were found, are
counted as `refused`. What does not hold is printed with its seed, and the exit code is 1.
"""

from __future__ import annotations

import csv
import io
import json
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import all_types
from gspcli.errors import GspError
from gspcli.geometry.coordinates import choose, moved
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.motion.following.row_instances import at_values
from gspcli.solver import solve
from gspcli.spec import dumps
from tools.fuzz.attacks import attack_by_seeds, call

Array = NDArray[np.float64]

TURNS = (
    "plain", "repeated", "closed", "there and back", "at a fold", "steps", "spoilt"
)  # fmt: skip
SPOILT = ("nan", "inf", "", "1e999", "x", "1,2")
#: Poses that agree to this times their condition are the same; of others with a greater condition
#: than the second nothing is said.
SAME, SINGULAR = 1e-9, 1e5
#: Standard deviations of the motion between rows: radians, and lengths of platforms of size one.
TURN, SHIFT = 0.25, 0.25


@dataclass
class Attack:
    """A platform and a CSV file.

    Attributes
    ----------
    instance
        The platform.
    rows
        The file, numbers only: t, six values and the coordinate that moves, if one does.
    names
        Its heading.
    options
        More options of `gsp track`.
    cell
        Row and column of what is spoilt, and with what.
    """

    instance: Instance
    rows: Array
    names: list[str]
    options: list[str] = field(default_factory=list)
    cell: tuple[int, int, str] | None = None

    @property
    def text(self) -> str:
        """The file."""
        lines = [[repr(x) for x in row] for row in self.rows.tolist()]
        if self.cell is not None:
            row, column, what = self.cell
            lines[row][column] = what
        return "\n".join(",".join(line) for line in [self.names, *lines]) + "\n"

    @property
    def steps(self) -> int:
        """How many steps are written for each row that is given."""
        return int(self.options[1]) if self.options else 1

    @cached_property
    def written(self) -> Array:
        """The rows that are written, of numbers."""
        count, steps = len(self.rows), self.steps
        places = np.arange((count - 1) * steps + 1) / steps
        return np.stack([np.interp(places, np.arange(count), x) for x in self.rows.T], axis=1)

    def at(self, row: Array) -> Instance:
        """Return the platform at a row."""
        chosen = choose(self.instance, self.names[7:])
        return at_values(moved(self.instance, chosen, row[7:]), row[1:7])

    def reversed(self) -> Attack:
        """Return the same from the last row to the first."""
        rows = self.rows[::-1].copy()
        rows[:, 0] = -rows[:, 0]
        return Attack(self.instance, rows, self.names, self.options)


def attack(turn: str, most: int, rng: np.random.Generator) -> Attack:
    """Return a random one."""
    types = [one for one in all_types() if generic_counts(one).one_sided <= most]
    instance, (R, T) = random_instance(types[rng.integers(len(types))], rng, one_sided=True)
    values = [measure(instance, R, T)]
    for _ in range(rng.integers(1, 4)):
        R = rotation_from_vector(TURN * rng.normal(size=3)) @ R
        T = T + SHIFT * rng.normal(size=3)
        values.append(measure(instance, R, T))
    names = ["t", *map(str, range(1, 7))]
    if turn == "repeated":
        values.insert(1, values[rng.integers(2)])
    if turn == "closed":
        values.append(values[0])
    if turn == "there and back":
        values += values[-2::-1]
    given = np.array(values)
    found = Attack(instance, np.column_stack((np.arange(len(given)), given)), names)
    if turn == "at a fold":
        _, document, _ = track(found, "json")
        folds = [event for event in (document or {}).get("events", []) if event["kind"] == "fold"]
        if folds:
            t = folds[rng.integers(len(folds))]["t"][rng.integers(2)]
            extra = [np.interp(t, found.rows[:, 0], x) for x in found.rows.T]
            found.rows = np.insert(found.rows, int(np.searchsorted(found.rows[:, 0], t)), extra, 0)
    if turn == "steps":
        found.options = ["--steps", str(rng.integers(2, 6))]
    if turn == "spoilt":
        where = int(rng.integers(len(given))), int(rng.integers(7))
        found.cell = (*where, SPOILT[rng.integers(len(SPOILT))])
    return found


def track(given: Attack, form: str) -> tuple[int, Any, str]:
    """Run `gsp track --complete`; return the exit code, what is written and what is said."""
    with tempfile.TemporaryDirectory() as folder:
        spec, values = Path(folder, "platform.yaml"), Path(folder, "values.csv")
        spec.write_text(dumps(given.instance), encoding="utf-8")
        values.write_text(given.text, encoding="utf-8")
        options = ["--complete", "--format", form, *given.options]
        code, text, said = call("track", str(spec), str(values), *options)
    if form == "csv":
        return code, list(csv.DictReader(io.StringIO(text))), said
    return code, json.loads(text) if text else None, said


def problems(given: Attack) -> Iterator[str]:
    """Yield what does not hold; the first word `refused` means that nothing can be said."""
    code, document, said = track(given, "json")
    if given.cell is not None:
        row, column, what = given.cell
        # A cell too many is a mistake of the line.
        place = f":{row + 2}" if what == "1,2" else f":{row + 2}:"
        if code != GspError.exit_code or place not in said:
            yield f"{what!r} in row {row}, column {column}: exit code {code}: {said!r}"
        return
    if code == 3 or (code == 4 and document is None):
        yield f"refused: {said!r}"
        return
    if document is None:
        yield f"exit code {code} and no document: {said!r}"
        return
    ends = [event for event in document["events"] if not event["begins"]]
    if code != (0 if document["complete"] and not ends else 4):
        yield f"exit code {code}, complete {document['complete']}, {len(ends)} ends"
    poses = [{key: float(x) for key, x in pose.items()} for pose in document["poses"]]
    _, rows, _ = track(given, "csv")
    written = [{key: float(row[key]) for key in poses[0]} for row in rows]
    # Their last bits may differ: paths of a later solve may begin elsewhere.
    if len(written) != len(poses) or not all(map(_alike, written, poses)):
        yield "CSV and JSON differ"
    yield from _accounts(given, document)
    yield from _poses(given, document)
    yield from _backwards(given, document)


def _alike(one: dict[str, float], other: dict[str, float]) -> bool:
    return np.allclose([*one.values()], [*other.values()], rtol=1e-9, atol=1e-9)


def _accounts(given: Attack, document: Any) -> Iterator[str]:
    """Yield which modes are not where they should be."""
    times = given.written[:, 0]
    for mode in document["modes"]:
        present = sorted(_row(given, p) for p in document["poses"] if p["mode"] == mode)
        events = [event for event in document["events"] if event["mode"] == mode]
        if len(events) > 1:
            yield f"mode {mode} has {len(events)} events"
        first, last = 0, len(times) - 1
        for event in events:
            if event["begins"]:
                first = event["row"]
            else:
                last = event["row"] - 1
            low, high = event["t"]
            # A step in which something happens contains it.
            inside = times[max(event["row"] - 1, 0)] <= high and (
                event["row"] == len(times) or low <= times[event["row"]]
            )
            if not (low <= high and inside):
                yield f"mode {mode}: an event at {event['t']} after row {event['row']}"
        if present != list(range(first, last + 1)):
            yield f"mode {mode} is at rows {present}, expected {first} to {last}"


def _row(given: Attack, pose: Any) -> int:
    """Return the number of the row of a pose."""
    return int(np.abs(given.written[:, 0] - pose["t"]).argmin())


def _study(pose: Any) -> Array:
    return np.array([pose[key] for key in ("qw", "qx", "qy", "qz", "x", "y", "z")])


def _apart(a: Array, b: Array) -> Array:
    """Return the distances of poses as (quaternion, position), (n, m); signs do not matter."""
    flipped = b * np.array([-1.0] * 4 + [1.0] * 3)
    near, turned = (np.linalg.norm(a[:, None] - c, axis=2) for c in (b, flipped))
    return np.asarray(np.minimum(near, turned))


def _poses(given: Attack, document: Any) -> Iterator[str]:
    """Yield at which rows the poses are not those of a complete set."""
    undecided = any(event["kind"] == "undecided" for event in document["events"])
    last = len(given.written) - 1
    for k, row in enumerate(given.written):
        here = [pose for pose in document["poses"] if _row(given, pose) == k]
        conditions = np.array([pose["condition"] for pose in here])
        try:
            result = solve(given.at(row))
        except GspError:
            continue
        if result.verdict != "complete" or (conditions > SINGULAR).any():
            continue
        quaternions = result.quaternions[result.real].real
        every = np.concatenate((quaternions, result.T[result.real].real), axis=1)
        followed = np.array([_study(pose) for pose in here]).reshape(-1, 7)
        near = _apart(followed, every) < SAME * (1 + conditions[:, None])
        if not (near.sum(axis=1) == 1).all() or (near.sum(axis=0) > 1).any():
            yield f"row {k}: {near.sum(axis=1)} poses of {len(every)} are those of modes"
        if k in (0, last) and not undecided and len(here) != len(every):
            yield f"row {k}: {len(here)} modes, {len(every)} poses"


def _backwards(given: Attack, document: Any) -> Iterator[str]:
    """Yield what is otherwise when the same is followed from the last row to the first."""
    _, back, said = track(given.reversed(), "json")
    if back is None:
        yield f"nothing backwards: {said!r}"
        return
    pairs = []
    last = len(given.written) - 1
    for found, whose, ends in ((document, given, (0, last)), (back, given.reversed(), (last, 0))):
        through = []
        for mode in found["modes"]:
            at = {_row(whose, p): _study(p) for p in found["poses"] if p["mode"] == mode}
            if ends[0] in at and ends[1] in at:
                through.append((at[ends[0]], at[ends[1]]))
        pairs.append(np.array(through).reshape(-1, 2, 7))
    certain = all(e["kind"] == "fold" for found in (document, back) for e in found["events"])
    forth, again = pairs
    same = (_apart(forth[:, 0], again[:, 0]) < 1e-5) & (_apart(forth[:, 1], again[:, 1]) < 1e-5)
    if certain and not ((same.sum(axis=0) == 1).all() and (same.sum(axis=1) == 1).all()):
        yield f"{len(forth)} modes forth, {len(again)} back, {int(same.sum())} the same"
    folds = [
        sorted({round(sign * e["t"][0], 8) for e in found["events"] if e["kind"] == "fold"})
        for sign, found in ((1, document), (-1, back))
    ]
    if certain and (
        len(folds[0]) != len(folds[1]) or not np.allclose(folds[0], folds[1], rtol=0, atol=1e-7)
    ):
        yield f"folds at {folds[0]} forth, at {folds[1]} back"


def attacking(seed: int, rng: np.random.Generator, most: int) -> tuple[str, list[str]]:
    """Attack with one platform; return its type and turn, and what does not hold."""
    turn = TURNS[seed % len(TURNS)]
    given = attack(turn, most, rng)
    return f"{turn}, {given.instance.type.id}", list(problems(given))


if __name__ == "__main__":
    sys.exit(attack_by_seeds(__doc__, attacking))
