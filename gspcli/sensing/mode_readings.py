"""The mode of a solved platform that fits the readings of sensors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.records import EqualByContent, dataclass
from gspcli.sensing.sensor_kinds import SensorReading, parse_reading
from gspcli.solver import SolveResult
from gspcli.wording import listed

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: A mode fits if no reading differs by more than this many standard deviations.
FITS = 3.0


@dataclass(frozen=True, eq=False)
class ReadingFit(EqualByContent):
    """The differences of readings from the expected ones at the m real modes of a platform.

    Attributes
    ----------
    result
        The modes: real poses, in this order.
    readings
        The r readings.
    expected
        The expected readings of each sensor at each mode: r arrays of shape (m, 1), for
        inclinometers (m, 2), in the units of the instance.
    off
        The differences of the readings from these, in their standard deviations, shape (m, r).
    """

    result: SolveResult
    readings: tuple[SensorReading, ...]
    expected: tuple[Array, ...]
    off: Array

    def __repr__(self) -> str:
        return f"<ReadingFit: {self.sentence}>"

    @cached_property
    def worst(self) -> Array:
        """The largest difference for each mode, shape (m,)."""
        return np.asarray(self.off.max(axis=1, initial=0.0))

    @property
    def fits(self) -> NDArray[np.bool_]:
        """Which modes fit: all readings are within three standard deviations, shape (m,)."""
        return np.asarray(self.worst <= FITS)

    @property
    def modes(self) -> list[int]:
        """The numbers of the modes that fit, from 1, the best first."""
        order = np.argsort(self.worst, kind="stable")
        return [int(k) + 1 for k in order if self.fits[k]]

    @property
    def mode(self) -> int | None:
        """The number of the only mode that fits; None if there is no or more than one mode."""
        return self.modes[0] if len(self.modes) == 1 else None

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        what = "reading" if len(self.readings) == 1 else "readings"
        if not len(self.worst):
            return f"there is no mode that could fit the {what}"
        order = np.argsort(self.worst, kind="stable").tolist()
        texts = [f"{self.worst[k]:.3g}" for k in order]
        if not self.modes:
            nearest = f"mode {order[0] + 1} is nearest, off by {texts[0]} standard deviations"
            return f"no mode fits the {what}: {nearest}"
        if self.mode is None:
            names = listed(map(str, sorted(self.modes)), "and")
            return f"{len(self.modes)} modes fit the {what}: {names}"
        text = f"mode {self.mode} fits the {what}: off by {texts[0]} standard deviations"
        return f"{text}, the next, mode {order[1] + 1}, by {texts[1]}" if len(order) > 1 else text

    def rows(self) -> list[dict[str, Any]]:
        """Return for each mode its number, its difference, and whether it fits."""
        return [
            {"number": k + 1, "off": float(self.worst[k]), "fits": bool(self.fits[k])}
            for k in range(len(self.worst))
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return the modes as a table with the expected readings (pandas is imported now)."""
        import pandas as pd

        frame = pd.DataFrame(self.rows(), columns=["number", "off", "fits"])
        for reading, read in zip(self.readings, self.expected, strict=True):
            names = ("",) if read.shape[1] == 1 else (" rx", " ry")
            for name, column in zip(names, read.T, strict=True):
                frame[f"{reading.sensor}{name}"] = column
        return frame

    def to_json(self) -> dict[str, Any]:
        """Return the readings and which modes fit as plain data."""
        return {
            "readings": [
                {
                    "sensor": str(reading.sensor),
                    "values": list(reading.values),
                    "sigma": reading.sigma,
                }
                for reading in self.readings
            ],
            "fitting": self.modes,
        }

    def of_mode(self, k: int) -> dict[str, Any]:
        """Return the fit of a mode, by its index, as plain data."""
        return {
            "expected_readings": [read[k].tolist() for read in self.expected],
            "off": self.off[k].tolist(),
            "fits": bool(self.fits[k]),
        }


def parsed_readings(
    instance: Instance, readings: Sequence[str | SensorReading], *, repeated: bool = False
) -> list[SensorReading]:
    """Return readings that are given as texts or as such.

    Parameters
    ----------
    instance
        The platform of their names.
    readings
        One, or several.
    repeated
        Whether they may be those of constraints, too.

    Raises
    ------
    ArgumentError
        If there is none, or one is wrong.
    """
    given = [readings] if isinstance(readings, str | SensorReading) else list(readings)
    if not given:
        message = "found none, expected at least one"
        raise ArgumentError(message, "readings")
    parsed: list[SensorReading] = []
    for k, one in enumerate(given):
        if isinstance(one, SensorReading):
            parsed.append(one)
            continue
        try:
            parsed.append(parse_reading(one, instance, repeated=repeated))
        except ArgumentError as error:
            message = f"readings[{k}], {error.where}" if error.where else f"readings[{k}]"
            raise ArgumentError(error.message, message) from None
    return parsed


def fit_readings(result: SolveResult, readings: Sequence[str | SensorReading]) -> ReadingFit:
    """Return the differences of readings from the expected ones at each real mode.

    Parameters
    ----------
    result
        A solved platform, as `gspcli.solve` returns it.
    readings
        Texts such as ``"leg P7 B7 = 212.4 ± 0.1"`` (`gspcli.sensing.sensor_kinds`); their errors
        are independent.

    Raises
    ------
    ArgumentError
        If there is none, or one is wrong; the column of the mistake is named.

    Examples
    --------
    >>> import gspcli
    >>> from gspcli.resources import instance_files
    >>> m2 = gspcli.load(instance_files()["rubin-m2"])
    >>> gspcli.fit_readings(gspcli.solve(m2), ["leg P1 B2 = 2.913 ± 0.002"]).mode
    2
    """
    instance, shown = result.instance, result.drawn
    parsed = parsed_readings(instance, readings)
    R, T = shown.R[shown.real].real, shown.T[shown.real].real
    expected = tuple(one.sensor.read(instance, R, T) for one in parsed)
    off = np.stack(
        [
            one.sensor.apart(instance, read, np.array(one.values)) / one.sigma
            for one, read in zip(parsed, expected, strict=True)
        ],
        axis=1,
    )
    for array in (off, *expected):
        array.setflags(write=False)
    return ReadingFit(result, tuple(parsed), expected, off)
