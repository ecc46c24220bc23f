"""The option `--reading`: which mode fits what further sensors read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gspcli.errors import CheckFailed, GspError
from gspcli.wording import shown as quoted

if TYPE_CHECKING:
    from gspcli.cli.pose_tables import Shown
    from gspcli.geometry.instance import Instance
    from gspcli.sensing import ReadingFit
    from gspcli.sensing.notation import SensorReading
    from gspcli.solver import SolveResult


def given_readings(
    texts: Sequence[str], instance: Instance, *, repeated: bool = False
) -> list[SensorReading]:
    """Return the readings that are given; if `repeated` they may be those of constraints, too."""
    if not texts:
        return []
    from gspcli.sensing.notation import parse_reading

    found = []
    for text in texts:
        try:
            found.append(parse_reading(text, instance, repeated=repeated))
        except GspError as error:
            message = f"--reading {quoted(text)}, {error}"
            raise GspError(message) from None
    return found


def fitted(result: SolveResult, readings: Sequence[SensorReading]) -> ReadingFit | None:
    """Return which modes fit the readings; None without readings."""
    if not readings:
        return None
    from gspcli.sensing import fit_readings

    return fit_readings(result, readings)


def refuse_misfit(fit: ReadingFit) -> None:
    """Raise, with what to do, unless exactly one mode fits."""
    if fit.mode is not None:
        return
    if fit.modes:
        message = "gsp sensors says which further sensor tells them apart"
        raise CheckFailed(f"{len(fit.modes)} modes fit what was read: {message}")
    message = "is it in the units of SPEC, with the values of SPEC (--set gives others)?"
    raise CheckFailed(f"no mode fits what was read: {message}")


def add_fit(document: dict[str, Any], shown: Shown, fit: ReadingFit) -> None:
    """Add to a document how the readings fit its poses."""
    document |= fit.to_json()
    for entry, index in zip(document["solutions"], shown.indices, strict=True):
        if index < len(fit.off) and fit.result.counts.real:
            entry |= fit.of_mode(index)
