"""The result of a fit of poses to more than six measurements."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.records import EqualByContent, dataclass
from gspcli.wording import counted, listed

if TYPE_CHECKING:
    import pandas as pd

    from gspcli.sensing.pose_numbers import PoseNumbers

Array = NDArray[np.float64]

#: A pose fits if a chi-squared as large occurs at least so often by chance.
FITS = 1e-3
#: Decimals of residuals in JSON, in standard deviations: more are those of rounding errors.
_DECIMALS = 4


@dataclass(frozen=True, eq=False)
class FittedPose:
    """A minimum of the sum of squares.

    Attributes
    ----------
    R, T
        The pose, shapes (3, 3) and (3,).
    chi_squared, freedom
        The sum of squares of residuals over their deviations, and its degrees of freedom.
    covariance
        Of a small turn about the axes of the base (radians) and of T, shape (6, 6); infinite if
        the measurements do not determine the pose.
    residuals
        Measured less fitted numbers over their standard deviations, shape (m,).
    studentised
        The same over their own deviations: a residual is smaller than an error, since the pose
        follows it. NaN where no other measurement checks a number.
    owners
        The measurement of each number, shape (m,).
    """

    R: Array
    T: Array
    chi_squared: float
    freedom: int
    covariance: Array
    residuals: Array
    studentised: Array
    owners: NDArray[np.int64]

    @property
    def probability(self) -> float:
        """How often chi-squared is as large by chance; 1 without degrees of freedom."""
        return chance(self.chi_squared, self.freedom)

    @property
    def fits(self) -> bool:
        """Whether that is at least once in a thousand times."""
        return self.probability >= FITS

    @cached_property
    def sigma(self) -> Array:
        """Standard deviations of the turn (radians) and of T, shape (6,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @cached_property
    def measurement_sizes(self) -> Array:
        """The largest studentised residual of each measurement; NaN if there is none."""
        found = np.full(int(self.owners.max()) + 1, np.nan)
        for owner, size in zip(self.owners.tolist(), np.abs(self.studentised), strict=True):
            found[owner] = np.fmax(found[owner], size)
        return found


@dataclass(frozen=True, eq=False)
class Without:
    """The fit without one measurement.

    Attributes
    ----------
    measurement
        Which one, from 0: the six values, then the readings.
    alike
        Others that may be the outlier as well: their studentised residuals are as large.
    pose
        The best fit without it.
    """

    measurement: int
    alike: tuple[int, ...]
    pose: FittedPose


@dataclass(frozen=True, eq=False)
class PoseFit(EqualByContent):
    """The poses that fit six values and further readings.

    Attributes
    ----------
    numbers
        What was measured.
    poses
        The distinct minima found, by their chi-squared.
    choices
        The choices of six measurements that were solved, each by the measurements in it.
    starts
        From how many poses the fits started.
    without
        The fit without the measurement that agrees least, if none fits; None otherwise.
    """

    numbers: PoseNumbers
    poses: tuple[FittedPose, ...]
    choices: tuple[tuple[int, ...], ...]
    starts: int
    without: Without | None

    def __repr__(self) -> str:
        return f"<PoseFit: {self.sentences[0]}>"

    @property
    def fitting(self) -> list[int]:
        """The numbers of the poses that fit, from 1."""
        return [k for k, pose in enumerate(self.poses, 1) if pose.fits]

    @property
    def sentences(self) -> list[str]:
        """The result in sentences."""
        count = len(self.numbers.owners)
        told = counted(count, "number")
        if not self.poses:
            return [f"no minimum was found from {counted(self.starts, 'pose')}"]
        best = self.poses[0]
        said = f"chi-squared {best.chi_squared:.4g} of {best.freedom}, probability "
        said += f"{best.probability:.2g}"
        if not self.fitting:
            first = f"no pose fits the {told}: the best has {said}"
        elif len(self.fitting) == 1:
            first = f"one pose fits the {told}: {said}"
        else:
            names = listed(map(str, self.fitting), "and")
            first = f"{len(self.fitting)} poses fit the {told}: {names}"
        if len(self.poses) > len(self.fitting) > 0:
            following = self.poses[len(self.fitting)]
            first += f"; the next has chi-squared {following.chi_squared:.4g}"
        lines = [
            first,
            f"{counted(len(self.poses), 'minimum', 'minima')} from {self.starts} starts, all poses "
            f"of {counted(len(self.choices), 'choice')} of six measurements; it is not proved that "
            "there are no others",
        ]
        if self.without is not None:
            lines += self._outlier(self.without)
        return lines

    def _outlier(self, without: Without) -> list[str]:
        """Return which measurement is the outlier, in sentences."""
        names, size = self.numbers.names, self.poses[0].measurement_sizes
        worst = without.measurement
        if without.alike:
            others = listed((names[k] for k in without.alike), "and")
            return [
                f"one measurement is wrong, and the data do not show which: {names[worst]} or "
                f"{others} (studentised residual {size[worst]:.3g}); more readings would tell"
            ]
        pose = without.pose
        what = f"the outlier is {names[worst]} (studentised residual {size[worst]:.3g}): without it"
        if pose.fits:
            said = f"chi-squared is {pose.chi_squared:.4g} of {pose.freedom}"
            return [f"{what} {said}, probability {pose.probability:.2g}"]
        said = f"{pose.chi_squared:.4g} of {pose.freedom}"
        return [
            f"{names[worst]} agrees least (studentised residual {size[worst]:.3g}), but without it "
            f"chi-squared is still {said}: more than one measurement is wrong"
        ]

    def rows(self) -> list[dict[str, Any]]:
        """Return the poses as rows of plain data."""
        found = []
        unit = self.numbers.instance.units.angle.in_radians
        for number, pose in enumerate(self.poses, 1):
            row: dict[str, Any] = {"number": number}
            row |= dict(zip(("Tx", "Ty", "Tz"), pose.T.tolist(), strict=True))
            turn = quaternion_from_rotation(pose.R).tolist()
            row |= dict(zip(("qw", "qx", "qy", "qz"), turn, strict=True))
            row |= {"chi_squared": pose.chi_squared, "probability": pose.probability}
            row |= {"sigma_T": float(pose.sigma[3:].max())}
            row |= {"sigma_turn": float(pose.sigma[:3].max()) / unit, "fits": pose.fits}
            found.append(row)
        return found

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        names = self.numbers.names
        without = self.without
        return {
            "freedom": self.poses[0].freedom if self.poses else 0,
            "measurements": [
                {"name": name, "values": values, "sigma": sigma}
                for name, values, sigma in zip(names, *self._measured(), strict=True)
            ],
            "choices": [[names[k] for k in choice] for choice in self.choices],
            "starts": self.starts,
            "fitting": self.fitting,
            "poses": [self._of(pose) for pose in self.poses],
            "outlier": None
            if without is None
            else {
                "name": names[without.measurement],
                "alike": [names[k] for k in without.alike],
                "without": self._of(without.pose),
            },
        }

    def _measured(self) -> tuple[list[list[float]], list[float]]:
        rows = self.numbers.instance.constraints
        values = [[row.value.value] for row in rows]
        values += [list(one.values) for one in self.numbers.readings]
        return values, [
            *self.numbers.sigmas.tolist(),
            *(one.sigma for one in self.numbers.readings),
        ]

    def _of(self, pose: FittedPose) -> dict[str, Any]:
        unit = self.numbers.instance.units.angle.in_radians
        scale = np.array([1 / unit] * 3 + [1.0] * 3)
        finite = bool(np.isfinite(pose.covariance).all())
        names = self.numbers.names
        return {
            "R": pose.R.tolist(),
            "T": pose.T.tolist(),
            "chi_squared": pose.chi_squared,
            "freedom": pose.freedom,
            "probability": pose.probability,
            "fits": pose.fits,
            "covariance": (pose.covariance * np.outer(scale, scale)).tolist() if finite else None,
            "residuals": [
                {
                    "name": names[owner],
                    "residual": _rounded(left),
                    "studentised": None if math.isnan(size) else _rounded(size),
                }
                for owner, left, size in zip(
                    pose.owners.tolist(),
                    pose.residuals.tolist(),
                    pose.studentised.tolist(),
                    strict=True,
                )
            ],
        }


def _rounded(size: float) -> float:
    return round(size, _DECIMALS) + 0.0


def chance(chi_squared: float, freedom: int) -> float:
    """Return how often chi-squared with some degrees of freedom is larger (closed form)."""
    if freedom <= 0:
        return 1.0
    half = chi_squared / 2
    if half > 700:
        return 0.0
    if freedom % 2 == 0:
        term = found = math.exp(-half)
        for k in range(1, freedom // 2):
            term *= half / k
            found += term
        return min(found, 1.0)
    found = math.erfc(math.sqrt(half))
    term = math.exp(-half) * math.sqrt(4 * half / math.pi) if half > 0 else 0.0
    for k in range(1, (freedom + 1) // 2):
        found += term
        term *= half / (k + 0.5)
    return min(found, 1.0)
