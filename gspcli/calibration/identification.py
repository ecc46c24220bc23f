"""What was found of a machine from its log: numbers, and conventions with how well they fit."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from gspcli.calibration.conventions import Turns
from gspcli.calibration.results import Calibration
from gspcli.geometry.instance import Instance
from gspcli.records import EqualByContent, dataclass
from gspcli.wording import listed

#: This many of the conventions that fit as well are named in sentences.
_SHOWN = 2


@dataclass(frozen=True, eq=False)
class Identification(EqualByContent):
    """A machine that was found from its log.

    Attributes
    ----------
    found
        The numbers of the machine with their covariance; what is stated there is the start.
    turns
        The convention of rotations.
    leg_unit, place_unit
        The units of lengths of legs and of positions; the file is in the first.
    stated_unit
        Whether the heading names the unit of legs; otherwise it is guessed.
    scatter
        Root mean square of the residuals of the lengths at exact poses, in the unit of legs.
    others
        The next best conventions, each in words with its residual, best first.
    ambiguous
        Those of them that fit as well, in words.
    offsets
        Whether a constant of each leg was estimated.
    with_offsets
        How well the lengths fit with such constants, if that is much better; None otherwise.
    bound
        How well lengths fit the linear equations, if that is so much better that joints may have
        been missed; None otherwise.
    """

    found: Calibration | None
    turns: Turns
    leg_unit: str
    place_unit: str
    stated_unit: bool
    scatter: float
    others: tuple[tuple[str, float], ...]
    ambiguous: tuple[str, ...]
    offsets: bool
    with_offsets: float | None = None
    bound: float | None = None

    def __repr__(self) -> str:
        unsure = f", {len(self.ambiguous)} as good" if self.ambiguous else ""
        return (
            f"<Identification: {self.turns.words()}{unsure}, legs in {self.leg_unit}, "
            f"positions in {self.place_unit}, scatter {self.scatter:.2g} {self.leg_unit}>"
        )

    @property
    def calibration(self) -> Calibration:
        """The numbers of the machine with their covariance."""
        assert self.found is not None
        return self.found

    @property
    def instance(self) -> Instance:
        """The machine that was found."""
        return self.calibration.instance

    @cached_property
    def sentences(self) -> list[str]:
        """Which conventions were found, in sentences."""
        unit = self.leg_unit
        how = "" if self.stated_unit else " (by their size: the log names no unit)"
        lines = [f"legs in {unit}{how}, positions in {self.place_unit}"]
        said = f"{self.turns.words()}: the lengths fit to {self.scatter:.2g} {unit}"
        if self.others:
            words, scatter = self.others[0]
            said += f"; next best {words}: {scatter:.2g} {unit}"
        lines.append(said)
        if self.with_offsets is not None:
            lines.append(
                f"with a constant of each leg (--estimate offsets) they fit to "
                f"{self.with_offsets:.2g} {unit}"
            )
        if self.ambiguous:
            some = list(self.ambiguous[:_SHOWN])
            if len(self.ambiguous) > _SHOWN:
                some.append(f"{len(self.ambiguous) - _SHOWN} others")
            fits = "fits" if len(some) == 1 else "fit"
            lines.append(
                f"ambiguous: {listed(some, 'and')} {fits} as well: say which is right, or add "
                "poses that turn more, about all axes"
            )
        return lines

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the log does not fit the machine, in sentences; empty if it does."""
        if self.bound is None:
            return self.calibration.doubts
        missed = (
            f"lengths fit to {self.scatter:.2g} {self.leg_unit}, linear equations to "
            f"{self.bound:.2g}: these are no legs between two joints, or other joints fit better"
        )
        return (missed, *self.calibration.doubts)

    @property
    def doubt(self) -> list[str]:
        """The next lines about a log that does not determine the machine, at most three."""
        lines = [f"best: {self.turns.words()}, where the lengths fit to {self.scatter:.2g} "]
        lines[0] += self.leg_unit
        return [*lines, *self.sentences[2:]]

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        turns = self.turns
        return {
            **self.calibration.to_json(),
            "doubts": list(self.doubts),
            "log": {
                "euler": turns.order,
                "senses": list(turns.senses),
                "axes": "".join("xyz"[axis] for axis in turns.axes) if turns.order else "",
                "angle_unit": turns.unit,
                "transposed": turns.transposed,
                "leg_unit": self.leg_unit,
                "position_unit": self.place_unit,
                "unit_stated": self.stated_unit,
                "scatter": self.scatter,
                "offsets": self.offsets,
                "others": [
                    {"what": what, "scatter": left, "as_good": what in self.ambiguous}
                    for what, left in self.others
                ],
            },
        }
