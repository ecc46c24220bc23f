"""Whether a fit can be believed: what data that fit the machine do not do.

Right data are doubted seldom: chi-squared is above its limit in one of a thousand, and a number is
three times as far from what is stated as it is known before.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.fitting import Fit
from gspcli.calibration.measurements import Noise
from gspcli.calibration.numbers import FileNumbers
from gspcli.geometry.instance import Instance
from gspcli.wording import counted

Array = NDArray[np.float64]

#: One of a thousand standard normal numbers is larger.
_SELDOM = 3.0902
#: A number may differ from what is stated by this many times what it is known to before.
_FAR = 3.0
#: An outlier of a robust fit is this many deviations away, and this part of the rows may have some.
_OUTLIER, _MANY = 5.0, 0.25


def quantile(freedom: int, z: float) -> float:
    """Return a quantile of chi-squared, by that of the normal law (Wilson and Hilferty 1931)."""
    part = 2 / (9 * freedom)
    found: float = freedom * max(1 - part + z * part**0.5, 0.0) ** 3
    return found


def judged_chi_squared(found: Fit, noise: Noise) -> tuple[float, int, int]:
    """Return chi-squared and its degrees of freedom without the rows with outliers.

    Also how many rows these are. A pose with an outlier is drawn to it, and with it all residuals
    of its row.
    """
    square = np.nan_to_num(found.residual) ** 2
    kept = square.max(axis=1, initial=0.0) <= _OUTLIER**2
    numbers = np.isfinite(found.residual).sum(axis=1)
    spare = numbers if noise.exact else np.maximum(numbers - 6, 0)
    return float(square[kept].sum()), found.freedom - int(spare[~kept].sum()), int((~kept).sum())


def doubts(
    instance: Instance,
    found: Fit,
    numbers: FileNumbers,
    stated: FileNumbers,
    noise: Noise,
    scatter: float,
    prior: float,
    *,
    robust: bool,
) -> tuple[str, ...]:
    """Return why the data do not fit the machine, in sentences; none if they do.

    Parameters
    ----------
    instance
        The platform as stated.
    found
        The fit.
    numbers, stated
        The numbers of the file for the model found, and as they are stated.
    noise, scatter
        The deviations, and what they are multiplied by; one if they were stated.
    prior
        How well the numbers are known before, a length.
    robust
        Whether outliers count less.
    """
    sentences = [] if found.converged else ["the fit did not come to an end"]
    length = instance.units.length
    chi, freedom, outliers = float(np.nansum(found.residual**2)), found.freedom, 0
    if robust and scatter == 1.0:
        chi, freedom, outliers = judged_chi_squared(found, noise)
    rows = len(found.residual)
    if outliers > _MANY * rows:
        sentences.append(f"{outliers} of {rows} rows are outliers by more than {_OUTLIER:g} sigma")
    if scatter == 1.0 and freedom > 0 and chi > (limit := quantile(freedom, _SELDOM)):
        sentences.append(
            f"chi-squared is {chi:.4g} of {freedom}: with the sigmas as stated it is above "
            f"{limit:.4g} once in 1000 times"
        )
    if scatter != 1.0 and noise.value * scatter > prior:
        sentences.append(
            f"the scatter ({noise.value * scatter:.2g} {length}) is more than what the numbers "
            f"are known to before ({prior:.2g} {length})"
        )
    changes, tolerance = numbers.values - stated.values, _tolerances(found, numbers, prior)
    far = np.flatnonzero(np.abs(changes) > _FAR * tolerance)
    if len(far):
        ratio = np.abs(changes[far]) / tolerance[far]
        worst = int(far[ratio.argmax()])
        more = f", and {counted(len(far) - 1, 'other number')} too" if len(far) > 1 else ""
        sentences.append(
            f"{numbers.names[worst]} changes by {changes[worst]:.3g}, {ratio.max():.2g} times what "
            f"it is known to before (--prior {prior:.2g} {length}){more}"
        )
    return tuple(sentences)


def _tolerances(found: Fit, numbers: FileNumbers, prior: float) -> Array:
    """Return how well each number of the file is known before; infinite for those of frames."""
    model = found.model
    free = model.free.copy()
    # Nothing is known of where a measuring device stands.
    frames = model.geometry + 12
    by = np.linalg.norm(numbers.slopes[:, free] * model.sizes[free], axis=1) * prior
    by[(numbers.slopes[:, frames:] != 0).any(axis=1)] = np.inf
    return np.where(by > 0, by, np.inf)
