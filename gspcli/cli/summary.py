"""The first sentence of `gsp solve`, and its last notes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gspcli.catalogue.kinds import DLL
from gspcli.geometry.primitives import Line
from gspcli.geometry.printed_numbers import printed_residual
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.solver.results.proof import CountKind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gspcli.solver import SolveResult

_DIGITS = 3
#: Poses that are this many lengths away are called nearly infinite.
_FAR = 1e5


def summary(result: SolveResult, *, contradicting: Sequence[int] = ()) -> list[str]:
    """Return the result in a sentence: the real poses, what is proved, whether these are all.

    Parameters
    ----------
    result
        The poses.
    contradicting
        Numbers from 1 of constraints that contradict each other, where there is no real pose.
    """
    lines = [f"{_real(result)}; {_completeness(result)}"]
    if fixed(result):
        one = result.counts.real == 1
        poses, them = ("the isolated real pose", "it") if one else ("these real poses", "them")
        lines.append(
            f"the platform cannot move from {poses}: the infinitely many others are another "
            f"component, apart from {them}"
        )
    if contradicting:
        lines.append(_reason(result, contradicting))
    return lines


def _real(result: SolveResult) -> str:
    real = result.counts.real
    # Those of a motion are real, too, and not counted.
    which = "isolated real" if result.verdict == "infinite" else "real"
    text = f"{real or 'no'} {which} pose{'s' * (real > 1)}"
    if lone := len(result.lone.R):
        return f"{lone} real pose{'s' * (lone > 1)} that cannot move"
    if not result.counts.found:
        return text
    # Without a real pose the certificates of the others prove that.
    known = proved(result)[:real] if real else proved(result)
    if known.all():
        return text + (", all proved different" if real > 1 else ", proved")
    if real == 0:
        return text
    return text + (f", {known.sum()} of them proved" if known.any() else ", not proved")


def fixed(result: SolveResult) -> bool:
    """Return whether poses are infinitely many, and all isolated real ones are proved isolated.

    A simple solution is in no larger set of them: no motion passes through it.
    """
    real = result.counts.real
    return result.verdict == "infinite" and real > 0 and bool(result.certified[:real].all())


def proved(result: SolveResult) -> NDArray[np.bool_]:
    """Return which poses are proved: by certificates, multiple ones by the exact count."""
    counted = result.proof is not None and result.proof.by is CountKind.EXACT
    return result.certified | (counted & (result.multiplicity > 1))


def _completeness(result: SolveResult) -> str:
    """Return the verdict, and how the paths end if not every one ends at a pose."""
    ends, found = result.account, result.counts.found
    verdict = f"{result.verdict}, {result.proof.words}" if result.proof else result.verdict
    if result.verdict == "complete" and found == result.expected:
        return f"{verdict}: all {found} of the type, real or not"
    poses = f"{found} pose{'s' * (found != 1)}, real or not"
    if result.verdict == "infinite":
        isolated = f"{found or 'no'} isolated one{'s' * (found != 1)}"
        where = " over the complex numbers" if len(result.lone.R) else ""
        return (
            f"{verdict}: infinitely many poses{where} and {isolated}; "
            f"the type can have {result.expected}"
        )
    if ends.found != found:
        poses += f", {ends.found} with multiplicities"
    named = {
        "at infinity": ends.at_infinity,
        "on curves": ends.on_curves,
        "where parallel lines have another distance": ends.spurious,
        "lost": ends.lost,
    }
    others = [f"{count} {where}" for where, count in named.items() if count]
    where = "".join(f", {other}" for other in others)
    geometry = result.geometry_count
    if geometry is None:
        return f"{verdict}: {poses}{where}, of the type's {result.expected}"
    # The causes for which the geometry has fewer poses than the type are not listed.
    gone = ends.on_curves + ends.spurious + ends.lost
    if geometry < ends.found:
        # A platform of this geometry with other values has fewer poses.
        return f"{verdict}: {poses}; the type can have {result.expected}"
    whole = f"this geometry's {geometry}; the type can have {result.expected}"
    if geometry == result.expected:
        whole = f"the type's {geometry}"
    return f"{verdict}: {poses}{where if gone else ''}, of {whole}"


def _reason(result: SolveResult, contradicting: Sequence[int]) -> str:
    constraints = result.instance.constraints
    kinds = {constraints[k - 1].kind.is_distance for k in contradicting}
    what = "constraint" if len(kinds) > 1 else "distance" if kinds == {True} else "angle"
    if len(contradicting) == 1:
        return f"no pose was found for {what} {contradicting[0]} alone"
    if len(contradicting) == len(constraints):
        return "any five of the constraints have common poses, all six have none"
    *first, last = map(str, contradicting)
    return (
        f"{what}s {', '.join(first)} and {last} contradict each other: "
        "no pose was found for them without the others"
    )


def remarks(result: SolveResult, numbers: Sequence[int]) -> list[str]:
    """Return notes on the poses shown, whose numbers count from 1."""
    if not numbers:
        return [*_far(result), *_parallel(result), *_ground(result)]
    limits = _limits(result, numbers)
    shown = [number - 1 for number in numbers]
    residual = printed_residual(float(result.residuals[shown].max()), result.arrangement.length)
    notes = [f"residuals at most {residual:.0e}"]
    # Mirrored poses differ in the last digits. Of poses with equal rounded numbers the first is
    # named.
    condition = np.array([float(f"{x:.{_DIGITS}g}") for x in result.conditions[shown]])
    best, worst = int(np.argmin(condition)), int(np.argmax(condition))
    lowest, highest = (f"{condition[k]:.{_DIGITS}g}" for k in (best, worst))
    if len(numbers) > 1 and lowest != highest:
        notes.append(
            f"best conditioned: pose {numbers[best]} ({lowest}); "
            f"worst: pose {numbers[worst]} ({highest})"
        )
    if len(numbers) > 1 and lowest == highest:
        notes.append(f"every pose has condition {lowest}")
    home = [result.home.text] if result.home and result.counts.real else []
    return ["; ".join(notes), *home, *limits, *_far(result), *_parallel(result), *_ground(result)]


def _limits(result: SolveResult, numbers: Sequence[int]) -> list[str]:
    """Say which of the real poses shown are outside the ranges and cones of the machine."""
    left = {number: result.solutions[number - 1].limits for number in numbers}
    ranges = {
        one.constraint for limits in left.values() for one in limits or () if one.kind == "range"
    }
    notes = [
        f"constraint {k + 1} is outside its range: the machine can take none of these poses"
        for k in sorted(ranges)
    ]
    beyond = [n for n, limits in left.items() if any(one.kind == "cone" for one in limits or ())]
    if beyond:
        names = ", ".join(map(str, beyond))
        notes.append(f"a leg leaves the cone of a joint in pose{'s' * (len(beyond) > 1)} {names}")
    beyond = [n for n, limits in left.items() if any(one.kind == "knee" for one in limits or ())]
    if beyond:
        names = ", ".join(map(str, beyond))
        notes.append(
            f"an arm or carriage is on the other side of its dead point than at home in "
            f"pose{'s' * (len(beyond) > 1)} {names}"
        )
    return notes


def _far(result: SolveResult) -> list[str]:
    """Say how many poses are nearly at infinity."""
    arrangement = result.arrangement
    offset = result.R @ arrangement.platform_centre + result.T - arrangement.base_centre
    far = int((np.abs(offset).max(axis=1) > _FAR * arrangement.length).sum())
    if not far:
        return []
    return [
        f"{far} of the {result.counts.found} poses lie beyond {_FAR:.0e} lengths: the geometry is "
        "nearly special"
    ]


def _parallel(result: SolveResult) -> list[str]:
    """Say which lines are parallel at all poses, if the poses are complete."""
    if result.verdict != "complete" or not result.account.spurious or not len(result.R):
        return []
    numbers = [
        str(number)
        for number, row in enumerate(result.instance.constraints, 1)
        if isinstance(row.platform, Line) and isinstance(row.base, Line) and row.kind is DLL
        if np.abs(np.cross(result.R @ row.platform.unit, row.base.unit)).max() < PARALLEL_SINE
    ]
    if not numbers:
        return []
    several = len(numbers) > 1
    names = f"s {', '.join(numbers[:-1])} and {numbers[-1]}" if several else f" {numbers[0]}"
    return [
        f"the lines of constraint{names} are parallel at every pose: "
        "a point of one has its distance from the other"
    ]


def _ground(result: SolveResult) -> list[str]:
    """Return that the proof is up to a random prime, in words, if it is."""
    said = "" if result.proof is None else result.proof.reservation
    return [said] if said else []
