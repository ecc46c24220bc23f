"""The option ``--require``: requirements of rows of poses, and the verdicts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from gspcli.cli.options import Function, option
from gspcli.cli.result import Field, Result
from gspcli.errors import CheckFailed, GspError
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.geometry.instance import Array, Instance
    from gspcli.geometry.machine import Machine
    from gspcli.motion.files.requirements import QuantityParts, Requirement, RequirementVerdict

#: The commands that compute the numbers which not every command has.
_SOURCES = {
    "force": "gsp analyze with --load, or gsp dynamics",
    "moment": "gsp analyze with --load, of a type with angles",
    "torque": "gsp analyze with --load, or gsp dynamics, of a platform with cranks",
    "stiffness": "gsp analyze with --stiffness",
    "power": "gsp dynamics",
    "frequency": "gsp dynamics with --modes",
    "error": "gsp analyze with --tolerance",
}


def require_option(
    example: str, otherwise: str = "else the exit code is 1, and the worst row of each is named"
) -> Callable[[Function], Function]:
    """Return a decorator that adds ``--require``, with an example and the consequence."""
    return option("--require WHAT", f"Every row must keep this: such as '{example}'; {otherwise}.")


def required(text: str | None) -> list[Requirement]:
    """Return the requirements of ``--require``; none without the option."""
    if text is None:
        return []
    from gspcli.motion.files.requirements import parse_requirements

    return parse_requirements(text)


def measured_quantities(
    instance: Instance,
    requirements: Sequence[Requirement],
    R: Array,
    T: Array,
    known: Mapping[str, Array | QuantityParts] | None = None,
    q: Array | None = None,
) -> dict[str, Array | QuantityParts]:
    """Return the numbers that requirements are about, at n poses R, T.

    Known numbers are those that the command has already computed. Drives are at q, shape (n, m), or
    where the poses ask them to be.

    Raises
    ------
    GspError
        If a number that is required is not known.
    """
    found = dict(known or {})
    for one in requirements:
        if one.quantity not in found:
            found[one.quantity] = _measured(instance, one.quantity, R, T, q)
    return found


def _measured(
    instance: Instance, name: str, R: Array, T: Array, q: Array | None
) -> Array | QuantityParts:
    from gspcli.geometry.machine import Machine
    from gspcli.motion.files.requirements import QuantityParts

    if name in _SOURCES:
        raise GspError(f"--require {name}: not known here, use {_SOURCES[name]}")
    if name == "gap":
        from gspcli.motion.collisions.compared import ComparedShapes

        if instance.shapes is None:
            stated = "SPEC states no shapes of its legs (shapes: {diameter: ...})"
            raise GspError(f"--require gap: {stated}")
        compared = ComparedShapes(instance)
        return QuantityParts(compared.gaps(R, T, q), compared.names)

    machine = Machine.of(instance)
    if name in ("range", "cone", "transmission"):
        from gspcli.motion.poses.inverse_kinematics import drive_values

        return _limits(machine, name, R, T, drive_values(instance, R, T)[1] if q is None else q)
    if name == "condition":
        from gspcli.geometry.measurement import condition_numbers, printed_conditions

        placed = machine.placed(R, T) if q is None else machine.arrangement(q)
        return printed_conditions(condition_numbers(placed, R, T))
    if name == "clearance":
        from gspcli.motion.singularities.clearances import clearances

        modes = None if q is None else machine.modes_at(R, T, q)
        return clearances(machine, R, T, working_modes=modes)[0]
    if machine.moves:
        raise GspError(
            "--require pose-clearance: not known of machines with cranks or slides, use clearance, "
            "which is that of their drives"
        )
    from gspcli.motion.singularities.pose_clearances import pose_clearances

    return pose_clearances(instance, R, T)


def _limits(machine: Machine, name: str, R: Array, T: Array, q: Array) -> QuantityParts:
    """Return the ``range`` or ``cone`` as shares, or the ``transmission``, at n poses R, T."""
    import numpy as np

    from gspcli.motion.files.requirements import QuantityParts

    if name == "cone":
        numbers = machine.cone_shares(R, T, q)
        names = [f"leg {cone.constraint + 1} at the {cone.body}" for cone in machine.cones]
    elif name == "range":
        shares = machine.range_shares(q)
        # A pose can be out of reach of a drive without a range, too.
        shares = np.where(np.isnan(shares) & np.isinf(shares).any(axis=0), 0.0, shares)
        stated = ~np.isnan(shares).all(axis=0)
        which = [*np.flatnonzero(stated & ~machine.moved), *np.flatnonzero(stated & machine.moved)]
        names = [("" if machine.moved[k] else "constraint ") + machine.names[k] for k in which]
        numbers = shares[:, which]
    else:
        which = np.flatnonzero(machine.driven).tolist()
        names = [f"{machine.names[machine.index[k]]}, rod {k + 1}" for k in which]
        numbers = machine.transmission(machine.gains(R, T, q))[:, which]
    if not names:
        what = "cranks and slides" if name == "transmission" else name
        raise GspError(f"--require {name}: SPEC states no {what}")
    return QuantityParts(numbers, names)


def refuse(verdicts: Sequence[RequirementVerdict]) -> None:
    """Raise `CheckFailed` if a requirement is not met."""
    if failed := [str(one.requirement) for one in verdicts if not one.met]:
        raise CheckFailed(f"not met: {listed(failed, 'and')}")


def settled(
    result: Result,
    requirements: Sequence[Requirement],
    R: Array,
    T: Array,
    places: Sequence[Mapping[str, Any]],
    known: Mapping[str, Array | QuantityParts] | None = None,
    drives: Array | None = None,
) -> tuple[Result, list[RequirementVerdict]]:
    """Return a result with what is required of it and the verdicts, and these.

    The result has a row for each of n poses R, T of its instance; `place_text` says what each place
    is. Known numbers are those that the command has already computed and shows. The readings of
    drives, shape (n, m), are those that the poses ask for if they are None.
    """
    if not requirements:
        return result, []
    from gspcli.geometry.machine import Machine
    from gspcli.motion.files.requirements import judge

    assert result.instance is not None
    known = known or {}
    q = None if drives is None else Machine.of(result.instance).from_readings(drives)
    found = measured_quantities(result.instance, requirements, R, T, known, q)
    verdicts = judge(requirements, found)
    more = {name: numbers for name, numbers in found.items() if name not in known}
    return judged(result, verdicts, more, places), verdicts


def judged(
    result: Result,
    verdicts: Sequence[RequirementVerdict],
    quantities: Mapping[str, Array | QuantityParts],
    places: Sequence[Mapping[str, Any]],
    *,
    between: bool = False,
) -> Result:
    """Return a result with verdicts, and with columns of the quantities that they need.

    With `between` JSON says which verdicts hold between the rows, too.
    """
    from gspcli.motion.files.requirements import QUANTITIES, QuantityParts

    rows, columns = [dict(row) for row in result.rows], [*result.columns]
    for name, given in quantities.items():
        key = name.replace("-", "_")
        heading = {"range": "of range", "cone": "of cone"}.get(name, name.replace("-", " "))
        if any(column.key == key for column in columns):
            continue
        columns.append(Field(key, heading, align="right", essential=True))
        if isinstance(given, QuantityParts):
            given = given.least if QUANTITIES[name].least else given.largest
        for row, number in zip(rows, given.tolist(), strict=True):
            row[key] = finite(number)
    lines, entries = [], []
    for one in verdicts:
        met = ("met, between rows too" if one.between else "met") if one.met else "NOT met"
        of = f", {one.part}" if one.part else ""
        worst = f"worst {one.worst:.6g}" if one.worst == one.worst else "not known"
        place = places[one.row]
        lines.append(f"{one.requirement}: {met}; {worst} {place_text(place)}{of}")
        entry = {"requirement": str(one.requirement), "met": one.met, "worst": finite(one.worst)}
        entry |= {"part": one.part or None, **place}
        entries.append(entry | ({"between": one.between} if between else {}))
    summary, head = [*result.summary, *lines], {**result.head, "requirements": entries}
    return replace(result, columns=columns, rows=rows, summary=summary, head=head)


def place_text(place: Mapping[str, Any]) -> str:
    """Return where a pose is, of its row, t and mode, in words: ``in row 7 (t = 1.5), mode 2``."""
    words = []
    if "row" in place:
        at = "" if place.get("t") is None else f" (t = {place['t']:.6g})"
        words.append(f"in row {place['row']}{at}")
    if place.get("mode") is not None:
        words.append(f"mode {place['mode']}" if words else f"in mode {place['mode']}")
    return ", ".join(words) or "there"


def finite(number: float) -> float | None:
    """Return a number for JSON, which has none that is not finite."""
    return number if abs(number) < float("inf") else None
