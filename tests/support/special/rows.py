"""Batches of one geometry with special values among others, judged row by row.

A row is judged by the recorded count of the platform whose numbers it has, by an exact count that
is made for it, and by the answer of `solve` to it alone. Its numbers are doubles, which stand for
the shortest decimals that denote them: a row for ``sqrt(52)`` is another platform, nearly special.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.counting import exact_count
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.readings import problems_of
from gspcli.solver import solve, solve_batch, solve_values
from gspcli.solver.poses import PoseBatch, PoseSet
from tests.support.special.answers import HONEST, Answer, judged
from tests.support.special.platforms import Draws, Platform, recorded

#: Relative changes of all values: 1e-1 to 1e-14. Each geometry has this many of them, at random.
_SHAKES, _EACH = range(1, 15), 4
#: The limit of work for the exact count of a row, as in `solve`.
_LIMIT = 2.0


@dataclass(frozen=True)
class Row:
    """One set of values.

    Attributes
    ----------
    name
        The platform with these values as doubles, and how they were changed.
    values
        Shape (6,).
    exact
        The row of the table for exactly these numbers, if there is one.
    is_wrong
        Whether the values are invalid: NaN, infinite, a negative distance or too large an angle.
    """

    name: str
    values: NDArray[np.float64]
    exact: Mapping[str, str] | None = None
    is_wrong: bool = False


def geometries(chosen: Iterable[Platform]) -> list[list[Platform]]:
    """Return platforms together that differ in their values only."""
    found: dict[object, list[Platform]] = defaultdict(list)
    for platform in chosen:
        instance = platform.instance
        rows = tuple((c.kind, c.platform, c.base, c.side) for c in instance.constraints)
        found[rows, instance.units].append(platform)
    return list(found.values())


def rows_of(platforms: list[Platform]) -> list[Row]:
    """Return sets of values for the geometry of some platforms, in a random order."""
    draws = Draws(f"{SEED} rows {platforms[0].id}")
    known = recorded()
    found = [_own(platform, known) for platform in platforms]
    instance = platforms[0].instance
    chosen = draws.sample(found, min(len(found), _EACH))
    for power, row in zip(draws.sample(_SHAKES, _EACH), chosen * _EACH, strict=False):
        shake = np.array([float(draws.decimal(1, 17)) for _ in range(6)])
        values = row.values * (1 + shake / 10**power)
        # An angle may be above 180 degrees then.
        is_wrong = bool(problems_of(instance, values[None]))
        found.append(Row(f"{row.name} shaken by 1e-{power}", values, is_wrong=is_wrong))
    own = chosen[0]
    distances = [k for k, row in enumerate(instance.constraints) if row.kind.is_distance]
    touching, wrong = own.values.copy(), own.values.copy()
    touching[draws.choice(distances)] = 0.0
    wrong[draws.choice(distances)] = draws.choice([np.nan, np.inf, -1.0])
    found += [
        Row(f"{own.name} with a distance of zero", touching),
        Row("wrong", wrong, is_wrong=True),
        own,
    ]
    draws.shuffle(found)
    return found


def _own(platform: Platform, known: Mapping[str, Mapping[str, str]]) -> Row:
    numbers = [constraint.value for constraint in platform.instance.constraints]
    values = np.array([number.value for number in numbers])
    same = [Number.of(x) for x in values.tolist()] == numbers
    return Row(platform.id, values, known.get(platform.id) if same else None)


def attacked(platforms: list[Platform]) -> tuple[str, list[tuple[str, str, str]]]:
    """Return the verdict on each row of a geometry.

    Returns
    -------
    name, remarks
        The first platform; and for each row its name, the verdict (a word of `answers`, or
        ``failed``), and the counts.
    """
    rows = rows_of(platforms)
    instance = platforms[0].instance
    values = np.array([row.values for row in rows])
    remarks = []
    try:
        sets = list(solve_values(instance, values, seed=SEED))
        batch = solve_batch(instance, values, seed=SEED)
        for k, (row, poses) in enumerate(zip(rows, sets, strict=True)):
            remarks.append((row.name, *_judged_row(instance, row, poses, _of_batch(batch, k))))
    except Exception as error:
        remarks.append(("all", "failed", repr(error)[:200]))
    return platforms[0].id, remarks


def _judged_row(instance: Instance, row: Row, poses: PoseSet, together: Answer) -> tuple[str, str]:
    if row.is_wrong or poses.problem:
        is_told = bool(poses.problem) == row.is_wrong and not len(poses.R)
        return ("right" if is_told else "failed"), f"problem: {poses.problem}"
    # Sets of values are these doubles: a shortest decimal may be on the other side of a fold.
    # Angles are decimals: there is no exact count for an angle with fifty of them.
    is_distance = [constraint.kind.is_distance for constraint in instance.constraints]
    numbers = [
        Number.of(Fraction(x) if exact else x)
        for x, exact in zip(row.values.tolist(), is_distance, strict=True)
    ]
    given = instance.with_values(dict(enumerate(numbers)))
    single = solve(given, seed=SEED)
    answers = [_answer(poses), _answer(single), together]
    exact = row.exact or _counted(given)
    said = "; ".join(f"{a.verdict} {a.found}/{a.multiple}, {a.real} real" for a in answers)
    if exact is not None:
        said += f"; exact: {exact['distinct']}/{exact['count']}, {exact['real'] or '?'} real"
        verdicts = [judged(answer, exact) for answer in answers]
    else:
        verdicts = ["incomplete" if a.verdict == "incomplete" else "right" for a in answers]
    for verdict in verdicts:
        if verdict not in HONEST:
            return verdict, said
    sure = [a for a in answers if a.verdict != "incomplete"]
    if len({(a.verdict, a.found, a.multiple, a.real) for a in sure}) > 1:
        return "differs", said
    return verdicts[0], said


def _answer(poses: PoseSet) -> Answer:
    return Answer(
        poses.account.verdict,
        len(poses.R),
        int(poses.multiplicity.sum()),
        int(poses.real.sum()),
        int(poses.certified.sum()),
        "none" if poses.proof is None else poses.proof.by.value,
        0.0,
    )


def _of_batch(batch: PoseBatch, k: int) -> Answer:
    verdict = "complete" if batch.complete[k] else "incomplete"
    if not batch.complete[k] and k in batch.others:
        verdict = batch.others[k].account.verdict
    return Answer(
        verdict,
        int(batch.number[k]),
        int(batch.multiplicity[k].sum()),
        int(batch.real[k].sum()),
        int(batch.certified[k].sum()),
        "proved" if batch.proved[k] else "none",
        0.0,
    )


def _counted(instance: Instance) -> dict[str, str] | None:
    """Return an exact count as a row of the table, or None if it takes too long."""
    count = exact_count(instance, seed=SEED + 1, limit=_LIMIT)
    if count is None:
        return None
    if not count.finite:
        return {"finite": "no", "count": "", "distinct": "", "real": ""}
    if count.distinct is None or count.spurious is None or count.solutions is None:
        return None
    return {
        "finite": "yes",
        "count": str(count.solutions - count.spurious),
        "distinct": str(count.distinct - (count.spurious_distinct or 0)),
        "real": "",
    }
