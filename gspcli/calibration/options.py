"""What is estimated and how, and how exactly it was measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.blocks import CORRECTIONS
from gspcli.calibration.measurements import Noise
from gspcli.calibration.parameters import Model
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass
from gspcli.wording import listed, shown, suggestion

#: How exactly the numbers of a platform are known before it is calibrated, in typical lengths:
#: parts are made to a two-hundredth of the machine. A number that data give less exactly counts as
#: unknown.
PRIOR = 1 / 200
#: The sorts of readings whose noise can be stated.
SIGMAS = ("value", "angle", "position", "rotation", "inclination", "crank", "slide")
_ANGLES = {"angle", "rotation", "inclination", "crank"}


@dataclass(frozen=True)
class Options:
    """What is estimated, and how.

    Attributes
    ----------
    estimate
        What is estimated besides primitives and offsets: ``scales``, ``frames``, or parameters, as
        ``base.B1.slide.offset``.
    hold
        What keeps what is stated: ``offsets``, ``platform``, ``base``, ``platform.P1``,
        ``offset.3`` ….
    robust
        Whether outliers, numbers more than five deviations away, are left out.
    prior
        What is known before, in length units; None for a two-hundredth of a typical length.
    hold_unknown
        Whether numbers that the data do not determine keep their stated values, instead of raising.
    """

    estimate: tuple[str, ...] = ()
    hold: tuple[str, ...] = ()
    robust: bool = False
    prior: float | None = None
    hold_unknown: bool = False


def prior_of(options: Options, model: Model) -> float:
    """Return how well the numbers are known before, a length.

    Raises
    ------
    ArgumentError
        If it is not a positive number.
    """
    if options.prior is None:
        return PRIOR * model.length
    if not 0 < options.prior < np.inf:
        message = f"found {options.prior:g}, expected a positive number"
        raise ArgumentError(message, "prior")
    return float(options.prior)


def chosen_model(instance: Instance, options: Options, *, drives: bool) -> Model:
    """Return the model with the parameters free that are to be estimated.

    Raises
    ------
    ArgumentError
        If a name is that of no parameter.
    """
    model = Model.of(instance, drives=drives)
    zeros = {f"{d.body}.{d.name}.{d.sort}.offset": d.drive_name for d in model.drives}
    if asked := [zeros[name] for name in options.estimate if name in zeros]:
        model = Model.of(instance, drives=drives, zeros=asked)
    free = model.free.copy()
    for name in options.estimate:
        meant = _meant(model, name, "estimate")
        # A whole primitive has no corrections of readings in it.
        free |= meant & ~_corrections(model, name)
    for name in options.hold:
        free[_meant(model, name, "hold")] = False
    if not free.any():
        message = "found nothing that is to be estimated"
        raise ArgumentError(message, "hold")
    return replace(model, free=free)


def _corrections(model: Model, but: str) -> NDArray[np.bool_]:
    """Return which parameters correct readings of drives, but for those with the name."""
    drives = {name for drive in model.drives for name in drive.names[-len(CORRECTIONS) :]}
    if but == "scales":
        drives = {name for name in drives if not name.endswith(".scale")}
    return np.array([name in drives and name != but for name in model.names])


def _meant(model: Model, name: str, where: str) -> NDArray[np.bool_]:
    """Return which parameters a name means: one, all of a primitive, of a body, or of a sort."""
    sorts = {
        "offsets": ("offset.",),
        "scales": ("scale.",),
        "frames": ("device.", "target."),
    }
    prefixes = sorts.get(name, (f"{name}.",))
    meant = np.array([one == name or one.startswith(prefixes) for one in model.names])
    if name == "scales":
        meant |= np.array([one.endswith(".scale") for one in model.names])
        # A rod that a drive moves is not read, but the drive is.
        rods = {f"scale.{k + 1}" for drive in model.drives for k in drive.rows}
        meant &= np.array([one not in rods for one in model.names])
    if not meant.any():
        parts = {one.rpartition(".")[0] for one in model.names} | set(model.names)
        known = sorted(parts | set(sorts) | {"platform", "base"})
        message = (
            f"found {shown(name)}, expected offsets, scales, frames, platform, base, or a name "
            f"such as {model.names[0].rpartition('.')[0]} or offset.1{suggestion(name, known)}"
        )
        raise ArgumentError(message, where)
    return meant


def noise_of(model: Model, sigma: Mapping[str, float]) -> Noise:
    """Return the standard deviations that are stated, or assumed.

    Raises
    ------
    ArgumentError
        If a name or a number is wrong.
    """
    changes: dict[str, Any] = {}
    exact = {"position", "rotation", "crank", "slide"}
    moved = {k for drive in model.drives for k in drive.rows}
    if all(k in moved for k, kind in enumerate(model.kinds) if kind.is_distance):
        exact.add("value")
    for name, number in sigma.items():
        if name not in SIGMAS:
            message = f"found {shown(name)}, expected {listed(SIGMAS)}{suggestion(name, SIGMAS)}"
            raise ArgumentError(message, "sigma")
        least = 0.0 if name in exact else np.nextafter(0, 1)
        if not (np.isfinite(number) and number >= least):
            expected = "a positive number" if least else "a number of at least 0"
            message = f"found {number:g}, expected {expected}"
            raise ArgumentError(message, f"sigma[{name!r}]")
        changes[name] = float(number) * (model.in_radians if name in _ANGLES else 1.0)
    noise = replace(Noise.usual(model.length), **changes)
    for drive, deviation in zip(model.drives, noise.of_drives(model), strict=True):
        if noise.value == deviation == 0:
            message = f"found both value and {drive.sort} zero, expected one of them positive"
            raise ArgumentError(message, "sigma")
    if (noise.position == 0) != (noise.rotation == 0):
        message = "found one of position and rotation zero, expected both (poses are exact) or none"
        raise ArgumentError(message, "sigma")
    return noise
