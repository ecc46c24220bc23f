"""From measurements to the numbers of a platform, or to the numbers that they do not determine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.calibration.fitting import HUBER, Fit, fit, redundancies
from gspcli.calibration.identifiable import Unknowns, advice, identifiable
from gspcli.calibration.judging import likely_cause
from gspcli.calibration.measurements import Measurements, Noise, constant_rods, value_rows
from gspcli.calibration.options import Options, chosen_model, noise_of, prior_of
from gspcli.calibration.parameters import Model
from gspcli.calibration.results import Calibration
from gspcli.calibration.starts import started
from gspcli.catalogue.kinds import DLL
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.wording import counted, shown, suggestion

Array = NDArray[np.float64]

#: Below this many deviations, by what is known before, a distance of lines may have either sign.
_SMALL = 3.0
#: What is this many times as large as the median is far out.
_FAR_OUT = 15.0
#: The threshold of a robust fit is at least this part of the usual one, for exact data.
_LEAST = 1e-3
#: An outlier is this many deviations away; they are looked for in at most this many rounds.
OUTLIER, _ROUNDS = 5.0, 100
#: Those above this part of the farthest are left out together.
_NEARLY = 0.7
#: Numbers of whose errors their residuals show less than this part are not judged.
_UNCHECKED = 1e-3
#: Where more than this part of the rows has outliers, no more are left out: the fit is doubted.
_TOO_MANY = 0.4
#: In this many lines an error says what is unknown.
_MOST_LINES = 3


def calibrate(
    instance: Instance,
    values: ArrayLike,
    R: ArrayLike | None = None,
    T: ArrayLike | None = None,
    *,
    points: Mapping[str, ArrayLike] | None = None,
    targets: Mapping[str, ArrayLike] | None = None,
    inclinations: ArrayLike | None = None,
    cranks: ArrayLike | None = None,
    drives: ArrayLike | None = None,
    sigma: Mapping[str, float] | None = None,
    estimate: Iterable[str] = (),
    hold: Iterable[str] = (),
    robust: bool = False,
    prior: float | None = None,
    hold_unknown: bool = False,
) -> Calibration:
    """Find the true numbers of a platform from measured values and poses.

    All that was measured has errors, poses too: they are found with the numbers of the platform, by
    least squares. Anything may be NaN: it was not measured then.

    Parameters
    ----------
    instance
        The platform as stated.
    values
        Readings in the units and order of the instance; DPH and DHP signed. Shape (n, 6). A leg
        with a crank or slide that has no reading in any row is a rod of constant length, without
        noise.
    R, T
        Rotations (n, 3, 3) and positions of the platform's origin (n, 3), as far as measured.
    points
        Positions of points of the platform that were measured, by the names of the primitives, or
        of `targets`; each (n, 3).
    targets
        Where such points are in the platform's frame, by name, each (3,).
    inclinations
        Angles of the platform's x and y axes above the horizontal, in the angle unit, (n, 2).
    cranks
        `drives` of a platform whose drives are cranks.
    drives
        Readings of the cranks and slides in the order of the constraints that they move, in the
        angle unit and lengths, shape (n, m). Points that share a drive have one column.
    sigma
        Standard deviations: ``value`` and ``position`` (lengths); ``angle``, ``rotation``,
        ``inclination`` and ``crank`` (in the angle unit), ``slide`` (a length). Poses are exact if
        those of position and rotation are 0; value may be 0 where all legs have drives. What is not
        stated is 1e-5 of a typical length or of a radian; if nothing is stated the scatter of the
        data says how large all are.
    estimate
        What is estimated besides primitives and offsets: ``scales``, ``frames`` (of the measuring
        device and the target), or parameters by name, as ``offset.2`` of a plane, or
        ``base.B1.slide.offset`` in place of a shift of B1 along its rail.
    hold
        What keeps what is stated: ``offsets``, ``platform``, ``base``, or names such as
        ``platform.P1``, ``offset.3``.
    robust
        Whether outliers, numbers more than five deviations away, are left out.
    prior
        How well the numbers are known before, in length units; a two-hundredth of a typical length
        if None. A direction that the data determine less exactly than that counts as undetermined.
    hold_unknown
        Whether numbers that the data do not determine keep their stated values, instead of raising.

    Returns
    -------
    Calibration
        Numbers with their covariance, the platform with them, poses and residuals.

    Raises
    ------
    IncompleteError
        If the data do not determine all numbers to be estimated; the message names the others, and
        what to measure.
    ArgumentError
        If an argument has a wrong shape or name.
    """
    if drives is None:
        drives, where = cranks, "cranks"
    elif cranks is None:
        where = "drives"
    else:
        message = "found both drives and cranks, expected drives"
        raise ArgumentError(message, "cranks")
    seen = _measurements(instance, values, R, T, points, targets, inclinations)
    if drives is not None:
        seen = replace(seen, drives=_readings_of_drives(instance, drives, len(seen), where))
    options = Options(tuple(estimate), tuple(hold), robust, prior, hold_unknown)
    return calibrate_rows(instance, seen, sigma or {}, options)


def calibrate_rows(
    instance: Instance, seen: Measurements, sigma: Mapping[str, float], options: Options
) -> Calibration:
    """Find the true numbers of a platform; as `calibrate`.

    Parameters
    ----------
    instance
        The platform as stated.
    seen
        What was measured.
    sigma
        As for `calibrate`.
    options
        What is estimated, and how.
    """
    checked(instance)
    model = chosen_model(instance, options, drives=seen.drives is not None)
    noise, seen = noise_of(model, sigma), constant_rods(instance, model, seen)
    if noise.exact and not (seen.whole.all() and len(seen)):
        message = "found poses that are not whole, expected whole ones where they are exact"
        raise ArgumentError(message, "sigma")
    prior = prior_of(options, model)
    _check_told(seen, noise)
    model, R, T, home = started(instance, model, seen, noise)
    start = model.anchored(R, T), R, T
    start = _with_signs(start, seen, noise, prior)
    if options.robust:
        found, seen, scatter = _robust(start, seen, noise, prior, stated=bool(sigma))
    else:
        found, scatter = _fitted(start, seen, noise, prior, stated=bool(sigma))
    unknown = identifiable(found, seen)
    if unknown.missing and not options.hold_unknown:
        raise IncompleteError(_refusal(instance, unknown, found, seen, prior))
    worst = _without_worst(found, seen, noise, prior / scatter)
    return Calibration(instance, found, seen, noise, scatter, unknown, options, worst, home)


def _fitted(
    start: tuple[Model, Array, Array],
    seen: Measurements,
    noise: Noise,
    prior: float,
    *,
    stated: bool,
) -> tuple[Fit, float]:
    """Return the fit, and the factor of all deviations if they were not stated."""
    if stated:
        return fit(*start, seen, noise, prior=prior), 1.0
    # How large the noise is, is known only when everything has been estimated.
    found = fit(*start, seen, noise)
    scatter = _scatter(found)
    if (found.known & (scatter > prior * found.singular)).any():
        found = fit(*start, seen, noise, prior=prior / scatter)
        scatter = _scatter(found)
    return found, scatter


def _robust(
    start: tuple[Model, Array, Array],
    seen: Measurements,
    noise: Noise,
    prior: float,
    *,
    stated: bool,
) -> tuple[Fit, Measurements, float]:
    """Return the fit without outliers, what was measured without them, and the factor of noise.

    Each number is judged by its residual over the deviation of that (data snooping, Baarda 1968):
    of the rows that have some beyond `OUTLIER` the farthest numbers are left out in turn, and the
    others are fitted by least squares, so that chi-squared and intervals are what they say. A fit
    with the pseudo-Huber loss is the start, and shows how large the noise is if that is not stated.
    """
    scatter, known = 1.0, prior if stated else np.inf
    found = fit(*start, seen, noise, huber=HUBER, prior=known)
    if not stated:
        scatter = max(_scatter(found, robust=True), _LEAST)
        found = fit(*start, seen, noise, huber=HUBER * scatter)
        scatter = max(_scatter(found, robust=True), _LEAST)
    left, rest = np.zeros(found.residual.shape, bool), seen
    for _ in range(_ROUNDS):
        found, factor = _fitted((found.model, found.R, found.T), rest, noise, prior, stated=stated)
        shown = redundancies(found, rest, noise)
        checked_ones = shown > _UNCHECKED
        sizes = np.abs(np.nan_to_num(found.residual))
        sizes = np.where(checked_ones, sizes / np.sqrt(np.where(checked_ones, shown, 1.0)), 0.0)
        largest = sizes.max(axis=1)
        far = np.flatnonzero((largest > OUTLIER * scatter) & (largest > _NEARLY * largest.max()))
        if not len(far) or left.any(axis=1).mean() > _TOO_MANY:
            break
        left = left.copy()
        left[far, sizes[far].argmax(axis=1)] = True
        rest = replace(seen, left_out=left)
    return found, rest, factor


def _with_signs(
    start: tuple[Model, Array, Array], seen: Measurements, noise: Noise, prior: float
) -> tuple[Model, Array, Array]:
    """Return a start at which small distances of lines have the sign that they have in truth.

    Readings of them have none. Those that are small are left out first: the others tell their sign.
    """
    model = start[0]
    lines = [k for k, kind in enumerate(model.kinds) if kind is DLL]
    if not lines:
        return start
    slopes = value_rows(*start, seen, noise).by_model[:, lines] * noise.value * model.sizes
    unsure = _SMALL * prior * np.linalg.norm(slopes[..., model.free], axis=-1)
    readings = seen.readings.copy()
    small = readings[:, lines] < unsure
    if not small.any():
        return start
    readings[:, lines] = np.where(small, np.nan, readings[:, lines])
    first = fit(*start, replace(seen, readings=readings), noise, prior=prior)
    return first.model, first.R, first.T


def _scatter(found: Fit, *, robust: bool = False) -> float:
    """Return the standard deviation of the residuals; of a robust fit without outliers."""
    if found.freedom <= 0:
        return 1e-9
    left = np.abs(found.residual[np.isfinite(found.residual)])
    if robust:
        left = left[left <= _FAR_OUT * np.median(left)]
    # Exact data leave nothing but rounding errors.
    return max(float(np.sqrt(np.sum(left**2) / found.freedom)), 1e-9)


def _without_worst(
    found: Fit, seen: Measurements, noise: Noise, prior: float
) -> tuple[int, Fit] | None:
    """Return the row that agrees least and the fit without it, if that tells as much."""
    if len(seen) < 2 or found.freedom <= 0:
        return None
    worst = int(np.nansum(found.residual**2, axis=1).argmax())
    rest = np.arange(len(seen)) != worst
    places = found.R[rest], found.T[rest]
    other = fit(found.model, *places, seen.taken(rest), noise, prior=prior)
    if other.freedom <= 0 or int(other.known.sum()) < int(found.known.sum()):
        return None
    return worst, other


def _check_told(seen: Measurements, noise: Noise) -> None:
    """Raise if no row has more numbers than a pose has."""
    if not len(seen) or (not noise.exact and int(seen.numbers.max()) <= 6):
        message = (
            "no row has more than six numbers; six are explained by a pose of any platform: "
            "measure values and poses, or points"
        )
        raise IncompleteError(message)


def _refusal(
    instance: Instance, unknown: Unknowns, found: Fit, seen: Measurements, prior: float
) -> str:
    """Return which numbers the data do not determine, and what to measure."""
    wanted = int(found.model.free.sum()) - unknown.frames
    told = wanted - unknown.missing
    lines = [f"the data determine {told} of {counted(wanted, 'number')}"]
    if unknown.sentences:
        lines[0] += "; they do not determine"
        rest = "; ".join(unknown.sentences[_MOST_LINES - 1 :])
        lines += [f"  {sentence}" for sentence in (*unknown.sentences[: _MOST_LINES - 1], rest)]
    lines = [line for line in lines if line.strip()]
    stated = Model.of(instance, drives=seen.drives is not None)
    cause = None
    if not found.model.with_frames:
        cause = likely_cause(stated, seen, prior, instance.units.length)
    if cause is not None:
        lines.append(cause)
    else:
        advised = advice(found, seen)
        lines.append(f"{advised}; or hold the others as stated (--hold-unknown)")
    return "\n".join(lines)


def _measurements(
    instance: Instance,
    values: ArrayLike,
    R: ArrayLike | None,
    T: ArrayLike | None,
    points: Mapping[str, ArrayLike] | None,
    targets: Mapping[str, ArrayLike] | None,
    inclinations: ArrayLike | None,
) -> Measurements:
    """Return what was measured, checked and in radians."""
    readings = _shaped(values, "values", (None, 6)).copy()
    n, unit = len(readings), instance.units.angle.in_radians
    angles = [k for k, row in enumerate(instance.constraints) if not row.kind.is_distance]
    readings[:, angles] *= unit
    blank = np.full((n, 3, 3), np.nan)
    at = {name: _shaped(one, f"targets[{name!r}]", (3,)) for name, one in (targets or {}).items()}
    seen = {name: _shaped(one, f"points[{name!r}]", (n, 3)) for name, one in (points or {}).items()}
    check_points(instance, list(seen), at, "points")
    return Measurements(
        readings,
        blank if R is None else _shaped(R, "R", (n, 3, 3)),
        blank[:, 0] if T is None else _shaped(T, "T", (n, 3)),
        np.zeros(3),
        seen,
        at,
        np.zeros((0, 2))
        if inclinations is None
        else _shaped(inclinations, "inclinations", (n, 2)) * unit,
        lines=tuple(str(k) for k in range(1, n + 1)),
    )


def _readings_of_drives(instance: Instance, given: ArrayLike, rows: int, where: str) -> Array:
    """Return readings of drives in radians and lengths, shape (rows, m)."""
    motors = Model.of(instance, drives=True).drives
    if where == "cranks" and any(drive.sort == "slide" for drive in motors):
        message = "found cranks of a platform with slides, expected drives"
        raise ArgumentError(message, where)
    units = [instance.units.angle.in_radians if one.sort == "crank" else 1.0 for one in motors]
    readings: Array = _shaped(given, where, (rows, len(motors))) * np.array(units)
    return readings


def check_points(
    instance: Instance, names: Iterable[str], targets: Mapping[str, object], where: str
) -> None:
    """Raise if a name is neither that of a point of the platform nor of a target."""
    known = [row.platform_name for row in instance.constraints if row.kind.platform.value == "P"]
    for name in names:
        if name not in known and name not in targets:
            message = (
                f"found the unknown point {shown(name)}, expected a point of the platform, or "
                f"where it is on the target{suggestion(name, known)}"
            )
            raise ArgumentError(message, where)


def _shaped(given: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    try:
        array = np.asarray(given, float)
    except (TypeError, ValueError):
        array = np.zeros(())
    fits = array.ndim == len(shape) and all(
        n in (None, m) for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits:
        expected = ", ".join("rows" if n is None else str(n) for n in shape)
        message = f"found shape {array.shape}, expected ({expected})"
        raise ArgumentError(message, name)
    if np.isinf(array).any():
        message = "found an infinite number, expected finite ones, NaN for what was not measured"
        raise ArgumentError(message, name)
    return array
