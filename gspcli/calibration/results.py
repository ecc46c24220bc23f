"""What a calibration found: numbers with their deviations, and how well they explain the data."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.fitting import Fit
from gspcli.calibration.identifiable import Unknowns
from gspcli.calibration.judging import doubts, likely_cause
from gspcli.calibration.measurements import Measurements, Noise
from gspcli.calibration.numbers import FileNumbers, calibrated, file_numbers
from gspcli.calibration.options import Options, prior_of
from gspcli.calibration.parameters import Model
from gspcli.geometry.instance import Instance
from gspcli.records import EqualByContent, dataclass

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Calibration(EqualByContent):
    """The numbers of a platform that were found from measurements.

    Attributes
    ----------
    stated
        The platform as it was given.
    fit
        The end of the fit: parameters, poses, residuals.
    seen
        What was measured.
    noise
        The standard deviations that were used.
    scatter
        What all deviations are multiplied by, because the noise was not stated: the root of
        chi-squared by its degrees of freedom. One if it was.
    unknowns
        The directions that the data do not determine; the numbers keep their stated values along
        them.
    options
        What was estimated, and how.
    without_worst
        The same without the row that agrees least, and its index; None if that is undecided.
    home
        With unknown frames and no stated home, which real pose was taken for it, in words.
    """

    stated: Instance
    fit: Fit
    seen: Measurements
    noise: Noise
    scatter: float
    unknowns: Unknowns
    options: Options
    without_worst: tuple[int, Fit] | None = None
    home: str = ""

    def __repr__(self) -> str:
        count = int(self.estimated.sum())
        chi = f"chi-squared {self.chi_squared:.4g} of {self.freedom}"
        unknown = f", {self.unknowns.missing} directions unknown" if self.unknowns.missing else ""
        doubted = ", doubted" if self.doubts else ""
        return f"<Calibration: {count} numbers from {len(self.seen)} rows, {chi}{unknown}{doubted}>"

    @cached_property
    def _found(self) -> FileNumbers:
        return file_numbers(self.stated, self.fit.model)

    @cached_property
    def _stated(self) -> FileNumbers:
        drives = self.seen.drives is not None
        return file_numbers(self.stated, Model.of(self.stated, drives=drives))

    @cached_property
    def estimated(self) -> NDArray[np.bool_]:
        """Which of all numbers of the file (and frames) depend on what was estimated."""
        by = self._found.slopes[:, self.fit.model.free]
        return np.asarray((by != 0).any(axis=1))

    @cached_property
    def repeated(self) -> int:
        """How many rows have the same numbers as one before: they count as measured again."""
        seen = self.seen
        parts = [seen.readings, seen.rotations.reshape(len(seen), -1), seen.positions]
        parts += [*seen.points.values(), *([seen.inclinations] if len(seen.inclinations) else [])]
        parts += [] if seen.drives is None else [seen.drives]
        rows = {row.tobytes() for row in np.hstack(parts)}
        return len(seen) - len(rows)

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """Why the data do not fit the machine, in sentences; empty if they do."""
        return doubts(
            self.fit,
            self._found,
            self._stated,
            self.noise,
            self.scatter,
            prior_of(self.options, self.fit.model),
            int(self.outliers.any(axis=1).sum()),
            self.stated.units.length,
        )

    @cached_property
    def cause(self) -> str | None:
        """Which mistake of the data probably is the cause of doubts; None if none is likely."""
        if not self.doubts or self.fit.model.with_frames:
            return None
        model = Model.of(self.stated, drives=self.seen.drives is not None)
        prior = prior_of(self.options, model)
        return likely_cause(model, self.seen, prior, self.stated.units.length)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the numbers found, m of them: ``base.B1.x``, ``offset.3`` …."""
        return tuple(np.array(self._found.names)[self.estimated].tolist())

    @cached_property
    def before(self) -> Array:
        """What was stated, shape (m,)."""
        return _fixed(self._stated.values[self.estimated])

    @cached_property
    def after(self) -> Array:
        """What was found, in the units of the file, shape (m,)."""
        return _fixed(self._found.values[self.estimated])

    @cached_property
    def covariance(self) -> Array:
        """The covariance of the numbers found, shape (m, m)."""
        whole = self._found.covariance(self.fit.covariance) * self.scatter**2
        return _fixed(whole[np.ix_(self.estimated, self.estimated)])

    @cached_property
    def sigma(self) -> Array:
        """Their standard deviations, shape (m,); zero for what keeps what is stated."""
        return _fixed(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)))

    @cached_property
    def deviations(self) -> dict[str, float]:
        """The standard deviation of each number found, by its name."""
        return dict(zip(self.names, self.sigma.tolist(), strict=True))

    @cached_property
    def instance(self) -> Instance:
        """The platform with the numbers found; readings stay unchanged, and get offsets."""
        return calibrated(self.stated, self.fit.model, self.deviations)

    @cached_property
    def R(self) -> Array:
        """The rotations found, shape (n, 3, 3)."""
        return _fixed(self.fit.R)

    @cached_property
    def T(self) -> Array:
        """The translations found, shape (n, 3)."""
        return _fixed(self.fit.T)

    @property
    def chi_squared(self) -> float:
        """The sum of squares of the residuals divided by their deviations."""
        return float(np.nansum(self.fit.residual**2))

    @property
    def freedom(self) -> int:
        """Its degrees of freedom."""
        return self.fit.freedom

    @cached_property
    def outliers(self) -> NDArray[np.bool_]:
        """Which numbers are left out, in the columns of `residuals` and `pose_residuals`."""
        left = self.seen.left_out
        return np.zeros(self.fit.residual.shape, bool) if left is None else left

    @cached_property
    def _residual(self) -> Array:
        """All residuals in standard deviations, those of outliers, too."""
        every = replace(self.seen, left_out=None)
        fit = self.fit
        return every.rows(fit.model, fit.R, fit.T, self.noise).residual

    @cached_property
    def residuals(self) -> Array:
        """The residual of each reading, in standard deviations, shape (n, 6); NaN for blanks."""
        return _fixed(self._residual[:, :6])

    @cached_property
    def pose_residuals(self) -> Array:
        """The residuals of what was measured of each pose, in deviations, shape (n, k)."""
        return _fixed(self._residual[:, 6:])

    @cached_property
    def rows(self) -> Array:
        """What each row adds to chi-squared, shape (n,)."""
        return _fixed(np.nansum(self.fit.residual**2, axis=1))

    @cached_property
    def worst(self) -> tuple[int, float, float] | None:
        """The row that agrees least, chi-squared without it, and the most that a number moves.

        The last in its standard deviations. None if the other rows alone do not determine as many
        numbers.
        """
        if self.without_worst is None:
            return None
        row, other = self.without_worst
        numbers = file_numbers(self.stated, other.model).values[self.estimated]
        known = self.sigma > 0
        moved = np.abs(numbers - self.after)[known] / self.sigma[known]
        left = float(np.nansum(other.residual**2))
        return row, left, float(moved.max(initial=0.0))

    def to_frame(self) -> DataFrame:
        """Return a row for each number: stated, found, sigma, and the change over sigma."""
        import pandas as pd

        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(self.sigma > 0, (self.after - self.before) / self.sigma, np.nan)
        columns = {
            "stated": self.before,
            "found": self.after,
            "sigma": self.sigma,
            "change_over_sigma": ratio,
        }
        return pd.DataFrame(columns, index=pd.Index(self.names, name="number"))

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data, covariance included."""
        model = self.fit.model
        worst = self.worst
        return {
            **self.stated.to_json(),
            "rows": len(self.seen),
            "chi_squared": self.chi_squared,
            "freedom": self.freedom,
            "scatter": self.scatter,
            "doubts": list(self.doubts),
            "cause": self.cause or "",
            "home_taken": self.home,
            "repeated_rows": self.repeated,
            "noise": {
                "value": self.noise.value,
                "angle": self.noise.angle / model.in_radians,
                "position": self.noise.position,
                "rotation": self.noise.rotation / model.in_radians,
                "inclination": self.noise.inclination / model.in_radians,
                "crank": self.noise.crank / model.in_radians,
                "slide": self.noise.slide,
            },
            "numbers": [
                {"name": name, "stated": a, "found": b, "sigma": s}
                for name, a, b, s in zip(
                    self.names,
                    self.before.tolist(),
                    self.after.tolist(),
                    self.sigma.tolist(),
                    strict=True,
                )
            ],
            "covariance": self.covariance.tolist(),
            "unknown": {
                "directions": self.unknowns.count,
                "frames": self.unknowns.frames,
                "what": list(self.unknowns.sentences),
            },
            "worst": None
            if worst is None
            else {
                "row": self.seen.lines[worst[0]],
                "chi_squared": float(self.rows[worst[0]]),
                "chi_squared_without": worst[1],
                "largest_change_over_sigma": worst[2],
            },
            "poses": [
                {"row": line, "R": R, "T": T, "chi_squared": chi}
                for line, R, T, chi in zip(
                    self.seen.lines,
                    self.R.tolist(),
                    self.T.tolist(),
                    self.rows.tolist(),
                    strict=True,
                )
            ],
        }


def _fixed(array: Array) -> Array:
    """Return an array that cannot be written to."""
    fixed = np.array(array)
    fixed.setflags(write=False)
    return fixed
