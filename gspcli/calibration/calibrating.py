"""From measurements to the numbers of a platform, or to the numbers that they do not determine.

Right data are doubted seldom: chi-squared is above its limit in one of a thousand, and a number is
three times as far from what is stated as it is known before. A mistake is named only where data
without it are as near to the machine as it is known before; otherwise no cause is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.calibration.fitting import HUBER, Fit, fit, redundancies, started
from gspcli.calibration.logs import check_points
from gspcli.calibration.measurements import (
    Measurements,
    Noise,
    constant_rods,
    left_jacobian,
    value_rows,
)
from gspcli.calibration.model import CORRECTIONS, FileNumbers, Model, calibrated, file_numbers
from gspcli.catalogue.kinds import DLL
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.checking import checked
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import (
    apply,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    vector_from_rotation,
)
from gspcli.records import EqualByContent, dataclass
from gspcli.spec import dumps
from gspcli.wording import counted, listed, shown, suggestion

if TYPE_CHECKING:
    from pandas import DataFrame


Array = NDArray[np.float64]

# Which numbers data determine: the null space of the derivatives, in words, and what to measure.
#
# Along some directions of the parameters nothing that was measured changes, or less than is known
# before. A basis of them in which each has a number that all others lack names the numbers. With an
# unknown measuring device and target twelve directions only say where the frames are.


#: A motion of a frame is unknown if it agrees with an unknown direction up to this: the first where
#: derivatives vanish, the second where noise hides it.
_EXACT, _HIDDEN = 1e-5, 0.1
#: A direction is described by at most this many numbers, those above a part of the largest, and at
#: most this many directions are.
_SHOWN, _PART, _MOST = 4, 0.2, 3
#: Poses that differ by less than these (radians; of a typical length) do not differ.
_SAME_TURN, _SAME_PLACE = 0.01, 1e-3


@dataclass(frozen=True)
class Unknowns:
    """What data do not determine."""

    #: Of how many independent directions.
    count: int
    #: How many of these only say where the frames of base and platform are; with an unknown
    #: measuring device and target they are kept as stated.
    frames: int
    #: Which the others are, in words.
    sentences: tuple[str, ...]

    @property
    def missing(self) -> int:
        """How many directions are unknown that should be known."""
        return self.count - self.frames


def identifiable(found: Fit, seen: Measurements) -> Unknowns:
    """Return the directions that the data of a fit do not determine."""
    model, rows = found.model, found.directions[~found.known]
    if not len(rows):
        return Unknowns(0, 0, ())
    rounding = found.singular[~found.known].max() <= 1e-9 * found.singular.max()
    limit = _EXACT if rounding else _HIDDEN
    left, frames = rows.copy(), 0
    for motion in _frame_motions(model):
        scaled = (motion / model.sizes)[model.free]
        direction = scaled / np.linalg.norm(scaled)
        part = left @ direction
        hidden = np.linalg.norm(direction - rows.T @ (rows @ direction)) <= limit
        if hidden and np.linalg.norm(part) > 0.1:
            frames += 1
            left = np.linalg.svd(part[None])[2][1:] @ left
    sentences = []
    if unread := _unread(seen):
        sentences.append(f"no row has a reading of {listed(map(str, unread), 'and')}")
    # With fewer numbers than are to be estimated any combination is unknown.
    enough = found.freedom + int(found.known.sum()) >= int(model.free.sum())
    if len(left) and enough:
        names = [name for name, free in zip(model.names, model.free, strict=True) if free]
        sentences += [_combination(row, names) for row in _sparse(left)[:_MOST]]
        if len(left) > _MOST:
            sentences.append(f"{len(left) - _MOST} more combinations of them")
    return Unknowns(len(rows), frames, tuple(sentences))


def _unread(seen: Measurements) -> list[int]:
    """Return the constraints, from 1, that have no reading in any row."""
    return (np.flatnonzero(~np.isfinite(seen.readings).any(axis=0)) + 1).tolist()


def _frame_motions(model: Model) -> Iterator[Array]:
    """Yield how all parameters change as a body moves with its device or target, each (p,)."""
    if not model.with_frames:
        return
    A, at = rotation_from_vector(model.frames[:3]), model.geometry + 12
    turns = [np.linalg.inv(left_jacobian(model.frames[k : k + 3])) for k in (0, 6)]
    for axis in np.eye(3):
        for body in ("base", "platform"):
            for turn in (np.zeros(3), axis):
                turning, change = bool(turn.any()), np.zeros(len(model.free))
                for block, span in model.spans():
                    if block.body == body:
                        shift = np.cross(axis, block.point) if turning else axis
                        parts = (block.shifts @ shift, block.tilts @ turn)
                        change[span][: len(block.shifts) + len(block.tilts)] = np.concatenate(parts)
                frames = change[at:]
                if body == "base":
                    # A body that moves by xi looks the same from a device moved by A xi A^-1.
                    frames[:3], frames[3:6] = turns[0] @ (-A @ turn), -A @ (axis - turn)
                else:
                    shift = np.cross(axis, model.frames[9:]) if turning else axis
                    frames[6:9], frames[9:] = turns[1] @ turn, shift
                yield change


def _sparse(rows: Array) -> Array:
    """Return rows that span the same space, each with a number that is zero in all other rows."""
    rows = rows.copy()
    for k in range(len(rows)):
        column = int(np.abs(rows[k:]).max(axis=0).argmax())
        best = k + int(np.abs(rows[k:, column]).argmax())
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, column], rows[k])
    return rows


def _combination(row: Array, names: list[str]) -> str:
    large = np.abs(row) > _PART * np.abs(row).max()
    shown: list[str] = [names[j] for j in np.argsort(-np.abs(row))[:_SHOWN].tolist() if large[j]]
    more = " among others" if int(large.sum()) > _SHOWN else ""
    if len(shown) == 1 and not more:
        return shown[0]
    return f"a combination of {listed(shown, 'and')}{more}"


def advice(found: Fit, seen: Measurements) -> str:
    """Return what to measure so that more is known."""
    model, points = found.model, [name for name in seen.points if name not in seen.targets]
    turned = np.linalg.svd(vector_from_rotation(found.R @ found.R[0].T), compute_uv=False)
    moved = np.linalg.norm(found.T - found.T.mean(axis=0), axis=1).max(initial=0.0)
    has_turns, has_places = (np.isfinite(a).any() for a in (seen.rotations, seen.positions))
    rows = np.isfinite(found.residual).sum(axis=1)
    lacking = int(model.free.sum()) - found.freedom - int(found.known.sum())
    more = counted(-(-lacking // max(int(rows.max(initial=7)) - 6, 1)), "more pose")
    part = not (seen.points or model.drives or model.with_frames)
    missing = _unread(seen)
    unread = listed(map(str, missing), "and") if missing else ""
    rules = (
        (unread, f"give readings of {unread}, or hold what only they use"),
        (
            (turned > _SAME_TURN).sum() < 2,
            "measure poses that turn the platform, about axes that differ",
        ),
        (
            moved < _SAME_PLACE * model.length,
            "measure poses that move the platform, along x, y and z",
        ),
        (
            points and not (has_turns or seen.targets),
            "say where points are on the platform (--target), or measure whole poses",
        ),
        (part and not has_places, "measure positions of the platform, too"),
        (part and not has_turns, "measure rotations, too, or three points of the platform"),
        (lacking > 0, f"measure at least {more}"),
    )
    otherwise = "measure poses farther apart, or more exactly; --plan N says which"
    return next((what for holds, what in rules if holds), otherwise)


#: One of a thousand standard normal numbers is larger.
_SELDOM = 3.0902
#: A number may differ from what is stated by this many times what it is known to before.
_FAR = 3.0
#: This part of the rows may have outliers.
_MANY = 0.25
#: Data without their mistake scatter by this part of what they do with it at most, and by less than
#: this many times what the machine is known to before.
_LESS, _KNOWN = 1 / 3, 3.0
#: At most this many rows are tested.
_ROWS = 1000
#: Units that are taken for another: powers of ten, inches and millimetres; degrees and radians.
_LENGTHS, _ANGLES = (1000.0, 100.0, 10.0, 25.4), (180 / np.pi,)


def quantile(freedom: int, z: float) -> float:
    """Return a quantile of chi-squared, by that of the normal law (Wilson and Hilferty 1931)."""
    part = 2 / (9 * freedom)
    found: float = freedom * max(1 - part + z * part**0.5, 0.0) ** 3
    return found


def _tolerances(found: Fit, numbers: FileNumbers, prior: float) -> Array:
    """Return how well each number of the file is known before; infinite for those of frames.

    Infinite, too, for a component of a unit vector along it: it changes by squares of tilts only.
    """
    model = found.model
    by = np.linalg.norm(numbers.slopes[:, model.free] * model.sizes[model.free], axis=1) * prior
    by[(numbers.slopes[:, model.geometry + 12 :] != 0).any(axis=1)] = np.inf
    return np.where(by > 1e-9 * prior * min(1, 1 / model.length), by, np.inf)


def likely_cause(model: Model, seen: Measurements, prior: float, unit: str) -> str | None:
    """Return the mistake without which the data are nearest to the machine as stated, in words.

    None if none of `mistakes` explains them up to what is known before, the length `prior`; or if
    no pose was measured whole.
    """
    if not seen.whole.any():
        return None
    rows = np.flatnonzero(seen.whole)
    seen = seen.taken(rows[:: -(-len(rows) // _ROWS)])
    before = _apart(model, seen)
    mended = ((_apart(model, replace(seen, **one)), what) for what, one in mistakes(model, seen))
    after, what = min(mended, key=lambda pair: pair[0])
    if not after < min(_LESS * before, _KNOWN * prior):
        return None
    return (
        f"probably {what}: the worst column scatters by {before:.2g} {unit} (median) about what "
        f"the machine as stated reads, and by {after:.2g} {unit} without that mistake"
    )


def _apart(model: Model, seen: Measurements) -> float:
    """Return how far the worst column of readings scatters about what the stated machine reads.

    The median of its rows, a length: wrong rows do not count, and an offset does not either.
    """
    seen = seen.taken(seen.whole)
    noise = Noise(1.0, 1 / model.length, 1.0, 1.0, 1.0, 0.0, 0.0)
    T = seen.positions - apply(seen.rotations, seen.pivot)
    with np.errstate(all="ignore"):
        left = value_rows(model, seen.rotations, T, seen, noise).residual
    columns = [column[np.isfinite(column)] for column in left.T]
    medians = [np.median(np.abs(one - np.median(one))) for one in columns if len(one)]
    return float(max(medians, default=np.inf))


def mistakes(model: Model, seen: Measurements) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield ten mistakes of files: in words, and what of the data differs without it."""
    distances = np.array([kind.is_distance for kind in model.kinds])
    cranks = np.array([drive.sort == "crank" for drive in model.drives], bool)
    drives = np.zeros((len(seen), 0)) if seen.drives is None else seen.drives
    R, T = seen.rotations, seen.positions
    every = np.ones(3, bool)
    units = (
        ("readings", seen.readings, distances & ~seen.rods, _LENGTHS, "the readings of lengths"),
        ("readings", seen.readings, ~distances, _ANGLES, "the readings of angles"),
        ("positions", T, every, _LENGTHS, "the measured positions"),
        ("drives", drives, cranks, _ANGLES, "the angles of cranks"),
        ("drives", drives, ~cranks, _LENGTHS, "the places of slides"),
    )
    for field, given, columns, factors, what in units:
        if columns.any() and given.shape[1]:
            for factor in factors:
                for size, times in (("small", factor), ("large", 1 / factor)):
                    mended = {field: given * np.where(columns, times, 1.0)}
                    yield f"{what} are too {size} by {factor:.4g}, as in another unit", mended
            if field == "drives":
                yield f"{what} have the wrong sign", {field: np.where(columns, -given, given)}
    read = np.flatnonzero(~seen.rods).tolist()
    names = [drive.drive_name for drive in model.drives][: drives.shape[1]]
    exchanged = [
        (seen.readings, "readings", "the readings", j, k) for j, k in combinations(read, 2)
    ]
    exchanged += [(T, "positions", "the positions", j, k) for j, k in combinations(range(3), 2)]
    exchanged += [
        (drives, "drives", "the readings of", j, k)
        for j, k in combinations(range(len(names)), 2)
        if cranks[j] == cranks[k]
    ]
    for given, field, what, j, k in exchanged:
        called = {"readings": [*"123456"], "positions": [*"xyz"], "drives": names}[field]
        order = np.arange(given.shape[1])
        order[[j, k]] = k, j
        yield f"{what} {called[j]} and {called[k]} are exchanged", {field: given[:, order]}
    back = np.swapaxes(R, 1, 2)
    yield "the rotations are transposed (from base to platform)", {"rotations": back}
    inverted = {"rotations": back, "positions": -apply(back, T)}
    yield "the poses are inverted (those of the base in the platform's frame)", inverted
    rolled = rotation_from_quaternion(np.roll(quaternion_from_rotation(R), 1, axis=1))
    yield "the quaternions have the scalar last", {"rotations": rolled}
    if seen.euler:
        angles = np.rad2deg(euler_from_rotation(seen.euler, R))
        turned = rotation_from_euler(seen.euler, angles)
        yield "rx, ry, rz are radians, not degrees", {"rotations": turned}


#: How exactly the numbers of a platform are known before it is calibrated, in typical lengths:
#: parts are made to a two-hundredth of the machine. A number that data give less exactly counts as
#: unknown.
PRIOR = 1 / 200
#: The sorts of readings whose noise can be stated.
SIGMAS = ("value", "angle", "position", "rotation", "inclination", "crank", "slide")
_OF_ANGLES = {"angle", "rotation", "inclination", "crank"}


@dataclass(frozen=True)
class Options:
    """What is estimated, and how."""

    #: What is estimated besides primitives and offsets: ``scales``, ``frames`` (of the measuring
    #: device and the target), or parameters by name, as ``offset.2`` of a plane, or
    #: ``base.B1.slide.offset`` in place of a shift of B1 along its rail.
    estimate: tuple[str, ...] = ()
    #: What keeps what is stated: ``offsets``, ``platform``, ``base``, ``platform.P1``, ``offset.3``
    #: ….
    hold: tuple[str, ...] = ()
    #: Whether outliers, numbers more than five deviations away, are left out.
    robust: bool = False
    #: How well the numbers are known before, in length units; None for a two-hundredth of a typical
    #: length. A direction that the data determine less exactly counts as undetermined.
    prior: float | None = None
    #: Whether numbers that the data do not determine keep their stated values, instead of raising.
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
        raise ArgumentError(f"found {options.prior:g}, expected a positive number", "prior")
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
        raise ArgumentError("found nothing that is to be estimated", "hold")
    return replace(model, free=free)


def _corrections(model: Model, but: str) -> NDArray[np.bool_]:
    """Return which parameters correct readings of drives, but for those with the name."""
    drives = {name for drive in model.drives for name in drive.names[-len(CORRECTIONS) :]}
    if but == "scales":
        drives = {name for name in drives if not name.endswith(".scale")}
    return np.array([name in drives and name != but for name in model.names])


def _meant(model: Model, name: str, where: str) -> NDArray[np.bool_]:
    """Return which parameters a name means: one, all of a primitive, of a body, or of a sort."""
    sorts = {"offsets": ("offset.",), "scales": ("scale.",), "frames": ("device.", "target.")}
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
            raise ArgumentError(f"found {number:g}, expected {expected}", f"sigma[{name!r}]")
        changes[name] = float(number) * (model.in_radians if name in _OF_ANGLES else 1.0)
    noise = replace(Noise.usual(model.length), **changes)
    for drive, deviation in zip(model.drives, noise.of_drives(model), strict=True):
        if noise.value == deviation == 0:
            message = f"found both value and {drive.sort} zero, expected one of them positive"
            raise ArgumentError(message, "sigma")
    if (noise.position == 0) != (noise.rotation == 0):
        message = "found one of position and rotation zero, expected both (poses are exact) or none"
        raise ArgumentError(message, "sigma")
    return noise


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
    def _as_stated(self) -> Model:
        return Model.of(self.stated, drives=self.seen.drives is not None)

    @cached_property
    def _before(self) -> Array:
        """All numbers of the file as stated."""
        return file_numbers(self.stated, self._as_stated).values

    @cached_property
    def prior(self) -> float:
        """How well the numbers are known before, a length."""
        return prior_of(self.options, self.fit.model)

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
        return len(seen) - len({row.tobytes() for row in np.hstack(parts)})

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """Why the data do not fit the machine, in sentences; empty if they do."""
        unit, rows, freedom = self.stated.units.length, len(self.seen), self.freedom
        sentences = [] if self.fit.converged else ["the fit did not come to an end"]
        wrong = int(self.outliers.any(axis=1).sum())
        if wrong > _MANY * rows:
            sentences.append(f"{wrong} of {rows} rows are outliers by more than 5 sigma")
        scattered = self.noise.value * self.scatter
        if self.scatter != 1.0 and scattered > self.prior:
            sentences.append(
                f"the scatter ({scattered:.2g} {unit}) is more than what the numbers are known to "
                f"before ({self.prior:.2g} {unit})"
            )
        elif freedom > 0 and self.scatter == 1.0:
            limit = quantile(freedom, _SELDOM)
            if self.chi_squared > limit:
                sentences.append(
                    f"chi-squared is {self.chi_squared:.4g} of {freedom}: with the sigmas as "
                    f"stated it is above {limit:.4g} once in 1000 times"
                )
        change = self._found.values - self._before
        ratio = np.abs(change) / _tolerances(self.fit, self._found, self.prior)
        if (far := ratio > _FAR).any():
            worst, others = int(ratio.argmax()), int(far.sum()) - 1
            more = f", and {counted(others, 'other number')} too" if others else ""
            sentences.append(
                f"{self._found.names[worst]} changes by {change[worst]:.3g}, {ratio[worst]:.2g} "
                f"times what it is known to before (--prior {self.prior:.2g} {unit}){more}"
            )
        return tuple(sentences)

    @cached_property
    def cause(self) -> str | None:
        """Which mistake of the data probably is the cause of doubts; None if none is likely."""
        if not self.doubts or self.fit.model.with_frames:
            return None
        return likely_cause(self._as_stated, self.seen, self.prior, self.stated.units.length)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the numbers found, m of them: ``base.B1.x``, ``offset.3`` …."""
        return tuple(np.array(self._found.names)[self.estimated].tolist())

    @cached_property
    def before(self) -> Array:
        """What was stated, shape (m,)."""
        return _fixed(self._before[self.estimated])

    @cached_property
    def after(self) -> Array:
        """What was found, in the units of the file, shape (m,)."""
        return _fixed(self._found.values[self.estimated])

    @cached_property
    def covariance(self) -> Array:
        """The covariance of the numbers found, shape (m, m)."""
        by = self._found.slopes
        whole = by @ self.fit.covariance @ by.T * self.scatter**2
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
        columns = {"stated": self.before, "found": self.after, "sigma": self.sigma}
        columns["change_over_sigma"] = ratio
        return pd.DataFrame(columns, index=pd.Index(self.names, name="number"))

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data, covariance included."""
        numbers = zip(
            self.names, self.before.tolist(), self.after.tolist(), self.sigma.tolist(), strict=True
        )
        poses = zip(
            self.seen.lines, self.R.tolist(), self.T.tolist(), self.rows.tolist(), strict=True
        )
        worst = None
        if self.worst is not None:
            row, without, change = self.worst
            worst = {
                "row": self.seen.lines[row],
                "chi_squared": float(self.rows[row]),
                "chi_squared_without": without,
                "largest_change_over_sigma": change,
            }
        unit = self.fit.model.in_radians
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
                name: getattr(self.noise, name) / (unit if name in _OF_ANGLES else 1.0)
                for name in SIGMAS
            },
            "numbers": [
                {"name": name, "stated": a, "found": b, "sigma": s} for name, a, b, s in numbers
            ],
            "covariance": self.covariance.tolist(),
            "unknown": {
                "directions": self.unknowns.count,
                "frames": self.unknowns.frames,
                "what": list(self.unknowns.sentences),
            },
            "worst": worst,
            "poses": [
                {"row": line, "R": R, "T": T, "chi_squared": chi} for line, R, T, chi in poses
            ],
        }


def _fixed(array: Array) -> Array:
    """Return an array that cannot be written to."""
    fixed = np.array(array)
    fixed.setflags(write=False)
    return fixed


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
    drives
        Readings of the cranks and slides in the order of the constraints that they move, in the
        angle unit and lengths, shape (n, m). Points that share a drive have one column.
    sigma
        Standard deviations: ``value`` and ``position`` (lengths); ``angle``, ``rotation``,
        ``inclination`` and ``crank`` (in the angle unit), ``slide`` (a length). Poses are exact if
        those of position and rotation are 0; value may be 0 where all legs have drives. What is not
        stated is 1e-5 of a typical length or of a radian; if nothing is stated the scatter of the
        data says how large all are.
    estimate, hold, robust, prior, hold_unknown
        As `Options` has them.

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
    seen = _measurements(instance, values, R, T, points, targets, inclinations)
    if drives is not None:
        units = Model.of(instance, drives=True).drive_units
        readings = _shaped(drives, "drives", (len(seen), len(units)))
        seen = replace(seen, drives=readings * units)
    options = Options(tuple(estimate), tuple(hold), robust, prior, hold_unknown)
    return calibrate_rows(instance, seen, sigma or {}, options)


def calibrate_rows(
    instance: Instance, seen: Measurements, sigma: Mapping[str, float], options: Options
) -> Calibration:
    """Find the true numbers of a platform from what was measured; as `calibrate`."""
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
        raise IncompleteError(
            "no row has more than six numbers; six are explained by a pose of any platform: "
            "measure values and poses, or points"
        )


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
        raise ArgumentError(f"found shape {array.shape}, expected ({expected})", name)
    if np.isinf(array).any():
        message = "found an infinite number, expected finite ones, NaN for what was not measured"
        raise ArgumentError(message, name)
    return array


def calibrated_text(result: Calibration, remarks_of_log: Sequence[str] = ()) -> str:
    """Return the file of what was found, with comments: ± the standard deviation of each number.

    Remarks of a log are comments at its head.
    """
    fits = f"chi-squared {result.chi_squared:.4g} of"
    if result.scatter != 1.0:
        fits = f"deviations of {result.noise.value * result.scatter:.2g} by the scatter,"
    head = [
        f"# calibrated by gsp calibrate from {len(result.seen)} rows: {fits} {result.freedom} "
        "degrees of freedom",
        "# after # are the standard deviations of the numbers in the line, in their order",
    ]
    if result.unknowns.missing:
        head.append(
            f"# {result.unknowns.missing} directions that the data do not determine are as stated:"
        )
        head += [f"#   {sentence}" for sentence in result.unknowns.sentences]
    head += [f"# {remark}" for remark in remarks_of_log]
    remarks = _remarks(result)
    lines, section = [], ""
    for line in dumps(result.instance).splitlines():
        if not line.startswith(" "):
            section = line.partition(":")[0]
            lines.append(line)
        else:
            remark = next(remarks) if section in ("platform", "base", "constraints") else ""
            lines.append(f"{line}  # {remark}" if remark else line)
    return "\n".join([*head, *lines]) + "\n"


def _remarks(result: Calibration) -> Iterator[str]:
    """Yield what stands beside each primitive and constraint, in the order of the file."""
    for body in ("platform", "base"):
        names = [
            getattr(row, f"{body}_name") or f"of {k}"
            for k, row in enumerate(result.stated.constraints, 1)
        ]
        for name in dict.fromkeys(names):
            begin = f"{body}.{name}."
            found = [s for one, s in result.deviations.items() if one.startswith(begin)]
            yield _deviations(found)
    for k in range(1, len(result.stated.constraints) + 1):
        parts = []
        for what in ("offset", "scale"):
            sigma = result.deviations.get(f"{what}.{k}")
            if sigma is not None:
                parts.append(f"{what} {_deviations([sigma])}")
        yield ", ".join(parts)


def _deviations(sigmas: list[float]) -> str:
    if not sigmas:
        return ""
    if not any(sigmas):
        return "as stated"
    return "± " + ", ".join(f"{sigma:.2g}" for sigma in sigmas)
