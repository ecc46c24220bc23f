"""From a log of legs and poses to the machine, without a file to start from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.calibrating import PRIOR, Calibration, Options, calibrate_rows
from gspcli.calibration.logs import Log, read_log
from gspcli.calibration.measurements import Measurements
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.building import distance
from gspcli.geometry.building import instance as instance_of
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.instance import METRES, HomePose, Instance
from gspcli.geometry.least_squares import descend
from gspcli.geometry.primitives import Point
from gspcli.geometry.quaternions import apply, quaternion_from_rotation
from gspcli.records import EqualByContent, dataclass
from gspcli.spec.document import text_of_table
from gspcli.wording import counted, listed

Array = NDArray[np.float64]

# Conventions: which of them make the lengths those of six legs.

#: Orders of the axes, about the axes of the platform; usual ones first. Those about the axes of the
#: base are the same, written backwards.
ORDERS = ("ZYX", "XYZ", "ZXY", "YXZ", "XZY", "YZX")
#: About which axes the three columns turn: as named, in reverse (A B C of KUKA), the others.
_AXES = ((0, 1, 2), (2, 1, 0), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1))
_SENSES = tuple((x, y, z) for x, y, z in product((1, -1), repeat=3))
#: How long a unit of positions is in units of lengths of legs, and what these units may be.
FACTORS = {
    1.0: ("", ""),
    1000.0: ("mm", "m"),
    1e-3: ("m", "mm"),
    10.0: ("mm", "cm"),
    0.1: ("cm", "mm"),
    100.0: ("cm", "m"),
    1e-2: ("m", "cm"),
    25.4: ("mm", "in"),
    1 / 25.4: ("in", "mm"),
}
_DEGREE = float(np.pi / 180)


@dataclass(frozen=True)
class Turns:
    """A convention of rotations."""

    #: The order of the axes of angles, about those of the platform; empty for whole rotations.
    order: str = ""
    #: Of the angles about x, y and z: 1, or -1 for the opposite of the right-hand rule.
    senses: tuple[int, int, int] = (1, 1, 1)
    #: The unit of angles.
    in_radians: float = 1.0
    #: Whether rotations are from the base's frame to the platform's.
    transposed: bool = False
    #: About which axis the angle of each column turns, 0 to 2 for x to z.
    axes: tuple[int, int, int] = (0, 1, 2)
    #: The headings of these columns if they do not name axes, such as ``A``; empty otherwise.
    heads: tuple[str, ...] = ()
    #: The unit of angles in the log, ``deg`` or ``rad``.
    unit: str = ""

    def rotations(self, log: Log, rows: NDArray[np.intp]) -> Array:
        """Return the rotations of some rows of a log, shape (n, 3, 3)."""
        found = log.turns[rows]
        if not log.has_angles:
            return np.swapaxes(found, 1, 2) if self.transposed else found
        turned = np.empty((len(rows), 3))
        turned[:, self.axes] = found
        return rotation_from_euler(self.order, turned * np.array(self.senses) * self.in_radians)

    @property
    def unusual(self) -> int:
        """How many senses are not those of the right-hand rule, and axes not in order."""
        return self.senses.count(-1) + self.transposed + (self.axes != (0, 1, 2))

    def words(self) -> str:
        """Return the convention in words."""
        if not self.order:
            how = "base to platform (transposed)" if self.transposed else "platform to base"
            return f"rotations from {how}"
        said = f"--euler {self.order}, {'degrees' if self.unit == 'deg' else 'radians'}"
        if self.axes != (0, 1, 2):
            there = " ".join("xyz"[axis] for axis in self.axes)
            said += f", {' '.join(self.heads)} about {there}"
        wrong = [f"r{axis}" for axis, one in zip("xyz", self.senses, strict=True) if one < 0]
        return f"{said}, {listed(wrong, 'and')} left-handed" if wrong else said


def turns_of(log: Log, euler: str | None) -> Iterator[Turns]:
    """Yield the conventions that rotations of a log may have, usual ones first.

    Angles in a known order, as `rotation_from_euler` takes it, follow the right-hand rule.
    """
    if not log.has_angles:
        yield Turns()
        yield Turns(transposed=True)
        return
    orders: tuple[str, ...] = ORDERS
    senses = _SENSES
    if euler is not None:
        orders, senses = (euler if euler.isupper() else euler[::-1].upper(),), _SENSES[:1]
    elif log.order is not None:
        orders = tuple(dict.fromkeys((log.order, *ORDERS)))
    units = (1.0,) if log.angle_unit else (_DEGREE, 1.0)
    axes = _AXES if log.heads else _AXES[:1]
    for unit, columns, order, sense in product(units, axes, orders, senses):
        said = log.angle_unit or ("rad" if unit == 1 else "deg")
        yield Turns(order, sense, unit, axes=columns, heads=log.heads, unit=said)


#: How many rows are used in linear equations, and in fits of joints; how many of the best
#: conventions are fitted.
_FIRST_ROWS, _ROWS, _FITTED = 200, 400, 16
#: Of conventions, or machines, of which the data are not a thousand times as likely none is chosen.
LIKELIER = float(2 * np.log(1000))
#: The residuals of exact data, and of usual logs, in lengths.
EXACT, USUAL = 1e-12, 1e-4
#: This many starts at random, for this many conventions, where linear equations do not decide.
_STARTS, _TRIED_AGAIN = 12, 4
#: Legs longer than this are in millimetres if nothing says their unit.
_MILLIMETRES = 10.0


class Convention(NamedTuple):
    """A convention of a log, and the legs that explain the lengths best with it."""

    turns: Turns
    factor: float
    place: int
    """Where it is among those that are tried, usual ones first."""
    scatter: float
    """Root mean square of the residuals of the lengths, in their unit."""
    joints: Array
    """Joints on the platform and on the base, and the missing constant, shape (6, 7)."""
    residual: Array
    """The residual of each length, shape (n, 6)."""

    def poses(self, log: Log, rows: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return R and T of some rows, T in the unit of lengths."""
        return self.turns.rotations(log, rows), log.positions[rows] * self.factor


def conventions(
    log: Log, rows: NDArray[np.intp], euler: str | None, *, offsets: bool
) -> tuple[list[Convention], float]:
    """Return conventions, the best first, and the scatter that any joints leave at least.

    All are judged by linear equations, up to noise; the best by fits of joints.
    """
    first, factors = _spread(rows, _FIRST_ROWS), _factors(log)
    tried = []
    for place, turns in enumerate(turns_of(log, euler)):
        R, T = turns.rotations(log, first), log.positions[first]
        left = left_of_lengths(R, T, log.lengths[first], factors, offsets=offsets)
        tried += [
            Convention(turns, factor, place, one, np.zeros(0), np.zeros(0))
            for factor, one in zip(factors.tolist(), left.tolist(), strict=True)
        ]
    tried.sort(key=lambda one: one.scatter)
    found = [_fitted(log, rows, one, offsets=offsets) for one in tried[:_FITTED]]
    if min(one.scatter for one in found) > USUAL * float(log.lengths[rows].mean()):
        # Linear equations may tell too little to start from.
        again = sorted(found, key=lambda one: one.scatter)[:_TRIED_AGAIN]
        again += [one for one in tried[:_TRIED_AGAIN] if one.place not in {a.place for a in again}]
        found += [_fitted(log, rows, one, offsets=offsets, random=True) for one in again]
        found.sort(key=lambda one: -one.scatter)
        found = list({(one.place, one.factor): one for one in found}.values())
    # Of equal ones the more usual is taken.
    least = min(one.scatter for one in found)
    alike = [one for one in found if _as_good(one.scatter, least, 6 * len(rows))]
    best = min(alike, key=lambda one: (one.turns.unusual, one.place))
    rest = [one for one in found if one is not best]
    return [best, *sorted(rest, key=lambda one: one.scatter)], tried[0].scatter


def _spread(rows: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Return at most so many of some rows, from the first to the last."""
    return np.asarray(rows[np.unique(np.linspace(0, len(rows) - 1, count).astype(int))])


def _fitted(
    log: Log, rows: NDArray[np.intp], one: Convention, *, offsets: bool, random: bool = False
) -> Convention:
    """Return a convention with the joints of least squares, each leg for itself."""
    lengths, (R, T) = log.lengths[rows], one.poses(log, rows)
    long = float(lengths.mean())
    starts = linear_starts(R, T, lengths, offsets=offsets)
    if random:
        starts = np.concatenate((starts, random_starts(long)))
    joints, left = fitted(R, T, lengths, starts, offsets=offsets)
    best, legs = (left**2).sum(axis=-1).argmin(axis=0), np.arange(6)
    residual = left[best, legs].T
    freedom = max(lengths.size - 6 * (7 if offsets else 6), 1)
    scatter = max(float(((residual**2).sum() / freedom) ** 0.5), EXACT * long)
    return one._replace(scatter=scatter, joints=joints[best, legs], residual=residual)


def _as_good(scatter: float, least: float, count: int) -> bool:
    """Whether normal residuals with one scatter are about as likely as with the least."""
    return 2 * count * float(np.log(scatter / least)) < LIKELIER


def _factors(log: Log) -> Array:
    """Return what positions may have to be multiplied by, to be in the unit of lengths."""
    if log.leg_unit and log.place_unit:
        return np.array([METRES[log.place_unit.lower()] / METRES[log.leg_unit.lower()]])
    return np.array(list(FACTORS))


def ambiguous(log: Log, rows: NDArray[np.intp], found: list[Convention]) -> list[str]:
    """Return the conventions that fit as well as the best and differ in the log, in words."""
    best, least = found[0], min(one.scatter for one in found)
    here = best.turns.rotations(log, rows)
    return [
        words_of(one, best, log)
        for one in found[1:]
        if _as_good(one.scatter, least, 6 * len(rows))
        and (
            one.factor != best.factor or np.abs(one.turns.rotations(log, rows) - here).max() > EXACT
        )
    ]


def words_of(one: Convention, best: Convention, log: Log) -> str:
    """Return a convention in words, its units if they differ from the best."""
    words = one.turns.words()
    if one.factor != best.factor:
        legs, places = units_of(log, one.factor)
        words += f", legs in {legs} and positions in {places}"
    return words


def units_of(log: Log, factor: float) -> tuple[str, str]:
    """Return the units of legs and of positions, as the heading says them or by their sizes."""
    if log.leg_unit and log.place_unit:
        return log.leg_unit, log.place_unit
    for known, size in ((log.leg_unit, factor), (log.place_unit, 1 / factor)):
        if known:
            wanted = METRES[known.lower()] * size
            other = next(
                (unit for unit, metres in METRES.items() if abs(metres / wanted - 1) < 1e-9),
                f"{size:g} {known}",
            )
            return (known, other) if log.leg_unit else (other, known)
    if factor != 1.0:
        return FACTORS[factor]
    unit = "mm" if float(np.nanmean(np.abs(log.lengths))) > _MILLIMETRES else "m"
    return unit, unit


# Joints of legs from lengths at known poses, without a first guess.
#
# The square of a length l is linear in the unknown joints p (platform) and b (base): ``l^2 - T.T =
# (p.p + b.b) + 2 U.p - 2 T.b - 2 R:(b p^T)`` with ``U = R^T T``, 16 unknowns a leg if the products
# of p and b count as unknowns of their own. A constant that is missing in the lengths is one more.
# If the log does not determine all of these, the solution of least norm is still a start of a
# descent for the six or seven numbers of a leg.

#: Unknowns of a leg in the linear equations, without the missing constant.
UNKNOWNS = 16
#: Singular values below this part of the largest are zero; the starts leave out more of them.
_ROUNDING, _KEPT = 1e-10, (16, 13, 10, 7)
_STEPS = 40
#: Of a robust fit rows are left out with residuals of more than this many times the median.
_ROUNDS, _FAR_OUT = 40, 10.0


def columns_of(R: Array, T: Array) -> Array:
    """Return the columns of the linear equations, scaled, shape (n, 16)."""
    size = float(np.abs(T).max(initial=0.0)) or 1.0
    U = np.einsum("nab,na->nb", R, T)
    return np.hstack((np.ones((len(T), 1)), U / size, T / size, R.reshape(-1, 9)))


def left_of_lengths(R: Array, T: Array, lengths: Array, factors: Array, *, offsets: bool) -> Array:
    """Return how far lengths are from the linear equations, root mean squares, shape (k,).

    Of lengths (n, 6) at poses (n, 3, 3) and (n, 3), with each of k factors of T.
    """
    basis, s, _ = np.linalg.svd(columns_of(R, T), full_matrices=False)
    basis = basis[:, s > _ROUNDING * s[0]]
    rho = (T**2).sum(axis=1)
    square = lengths**2

    def across(part: Array) -> Array:
        return np.asarray(part - basis @ (basis.T @ part))

    rest, of_rho, of_length = across(square), across(rho), across(lengths)
    left = rest[None] - factors[:, None, None] ** 2 * of_rho[None, :, None]
    if offsets:
        weight = (of_length**2).sum(axis=0)
        there = np.where(weight > 0, weight, 1.0)
        left = left - of_length * ((left * of_length).sum(axis=1) / there)[:, None]
    freedom = max(len(T) - basis.shape[1] - offsets, 1)
    found: Array = np.sqrt((left**2 / (4 * square.mean(axis=0))).sum(axis=(1, 2)) / (6 * freedom))
    return found


def linear_starts(R: Array, T: Array, lengths: Array, *, offsets: bool) -> Array:
    """Return starts for the joints, least-norm solutions with several ranks, shape (k, 6, 7)."""
    columns, rho = columns_of(R, T), (T**2).sum(axis=1)
    size = float(np.abs(T).max(initial=0.0)) or 1.0
    long = float(lengths.mean())
    starts = np.zeros((len(_KEPT), 6, 7))
    for leg, length in enumerate(lengths.T):
        full = np.column_stack((columns, -2 * length / long)) if offsets else columns
        U, s, V = np.linalg.svd(full, full_matrices=False)
        parts = U.T @ (length**2 - rho)
        for k, kept in enumerate(_KEPT):
            some = (np.arange(len(s)) < kept + offsets) & (s > _ROUNDING * s[0])
            found = V.T @ np.where(some, parts / np.where(some, s, 1.0), 0.0)
            joints = found[1:7] / (2 * size) * ([1] * 3 + [-1] * 3)
            starts[k, leg] = np.append(joints, found[16] / long if offsets else 0.0)
    return starts


def random_starts(long: float) -> Array:
    """Return joints at random, within about the length of legs, shape (k, 6, 7)."""
    starts = np.zeros((_STARTS, 6, 7))
    starts[..., :6] = long * np.random.default_rng(0).normal(size=(_STARTS, 6, 6))
    return starts


def fitted(
    R: Array,
    T: Array,
    lengths: Array,
    starts: Array,
    *,
    offsets: bool,
    weights: Array | None = None,
) -> tuple[Array, Array]:
    """Return where each start ends, (k, 6, 7), and the residuals there, (k, 6, n).

    With weights of lengths, shape (6, n), the residuals are multiplied by them.
    """
    count = 7 if offsets else 6

    def equations(joints: Array) -> tuple[Array, Array]:
        left, slopes = _equations(R, T, lengths, joints, weights)
        return left, slopes[..., :count]

    def moved(step: Array, joints: Array) -> tuple[Array]:
        return (joints + np.pad(step, ((0, 0), (0, 0), (0, 7 - count))),)

    ends = descend(equations, moved, (starts,), steps=_STEPS)
    return ends.point[0], ends.residuals


def without_far(
    R: Array, T: Array, lengths: Array, best: Convention, *, offsets: bool
) -> tuple[Convention, NDArray[np.bool_]]:
    """Return joints for which wrong lengths count little, and which rows have none of these.

    Repeated least squares with the weights of Cauchy's law, whose width is twice the median.
    """
    joints, left = best.joints, best.residual.T
    for _ in range(_ROUNDS):
        width = 2 * np.median(np.abs(left), axis=1, keepdims=True) + 1e-15 * lengths.mean()
        weights = (1 + (left / width) ** 2) ** -0.5
        joints = fitted(R, T, lengths, joints[None], offsets=offsets, weights=weights)[0][0]
        left = _equations(R, T, lengths, joints[None])[0][0]
    near = np.abs(left) <= _FAR_OUT * np.median(np.abs(left), axis=1, keepdims=True)
    kept = np.asarray(near.all(axis=0))
    scatter = float(np.sqrt((left[:, kept] ** 2).mean()))
    return best._replace(joints=joints, residual=left.T, scatter=scatter), kept


def _equations(
    R: Array, T: Array, lengths: Array, joints: Array, weights: Array | None = None
) -> tuple[Array, Array]:
    """Return the residuals of lengths, (k, 6, n), and their derivatives, (k, 6, n, 7)."""
    along = np.einsum("nab,klb->klna", R, joints[..., :3]) + T - joints[..., None, 3:6]
    size = np.maximum(np.linalg.norm(along, axis=-1), 1e-300)
    unit = along / size[..., None]
    by_p = np.einsum("nab,klna->klnb", R, unit)
    left = size - lengths.T - joints[..., None, 6]
    slopes = np.concatenate((by_p, -unit, -np.ones((*size.shape, 1))), axis=-1)
    if weights is not None:
        left, slopes = left * weights, slopes * weights[..., None]
    return left, slopes


#: This many of the conventions that fit as well are named in sentences.
_SHOWN = 2


@dataclass(frozen=True, eq=False)
class Identification(EqualByContent):
    """A machine that was found from its log.

    Attributes
    ----------
    calibration
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
    sentences
        Which conventions were found, in words.
    missed
        Why joints may have been missed, in words; empty if they were not.
    """

    calibration: Calibration
    turns: Turns
    leg_unit: str
    place_unit: str
    stated_unit: bool
    scatter: float
    others: tuple[tuple[str, float], ...]
    ambiguous: tuple[str, ...]
    offsets: bool
    sentences: tuple[str, ...]
    missed: str

    def __repr__(self) -> str:
        unsure = f", {len(self.ambiguous)} as good" if self.ambiguous else ""
        return (
            f"<Identification: {self.turns.words()}{unsure}, legs in {self.leg_unit}, "
            f"positions in {self.place_unit}, scatter {self.scatter:.2g} {self.leg_unit}>"
        )

    @property
    def instance(self) -> Instance:
        """The machine that was found."""
        return self.calibration.instance

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the log does not fit the machine, in sentences; empty if it does."""
        return (*([self.missed] if self.missed else []), *self.calibration.doubts)

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


#: This many rows more than unknowns of a leg are needed to tell conventions apart.
_SPARE = 2
#: Other joints differ by this part of a length.
_DIFFERENT = 1e-3
#: Joints may have been missed where the linear equations fit this many times better: their residual
#: is a lower bound. With few rows they fit so much better by chance.
_GAP, _BY_CHANCE = 5.0, 10.0
#: Positions that differ by less than this part of their size do not move.
_STILL = 1e-6
#: A constant of each leg is proposed where the lengths fit this many times better with it.
_BETTER = 5.0
_NONE = (
    "no machine with six legs explains the log: look for wrong rows, or try --robust; legs are the "
    "distances from joint to joint"
)


def identify(
    path: str,
    *,
    euler: str | None = None,
    offsets: bool = False,
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ignore: tuple[str, ...] = (),
    sigma: dict[str, float] | None = None,
    robust: bool = False,
) -> Identification:
    """Find a hexapod from a log of its legs and poses, without a file to start from.

    Parameters
    ----------
    path
        A CSV file with the columns 1 to 6 (lengths of legs), x y z and a rotation.
    euler
        The order of the axes of rx, ry, rz; found by trying if None.
    offsets
        Whether the lengths of each leg lack a constant, which is estimated.
    pivot
        The point of the platform whose position x, y, z are, in the platform's frame and the
        unit of legs; the frame of the result begins there if it is not given.
    ignore
        Columns that are left out.
    sigma, robust
        As for `calibrate`.

    Raises
    ------
    IncompleteError
        If the log does not determine the machine: what is missing.
    SpecError
        With all mistakes of the file.
    """
    text = text_of_table(path, str(path))
    options = Options(("offsets",) if offsets else (), robust=robust)
    log = read_log(text, str(path), ignore)
    return identify_log(log, euler, np.array(pivot, float), sigma or {}, options)


def identify_log(
    log: Log, euler: str | None, pivot: Array, sigma: dict[str, float], options: Options
) -> Identification:
    """Find a hexapod from a log; as `identify`.

    Positions are of the pivot, shape (3,). Offsets are held unless they are to be estimated.
    """
    if euler is not None and not log.has_angles:
        message = "found whole rotations, expected rx ry rz with an Euler sequence"
        raise ArgumentError(message, "euler")
    offsets = "offsets" in options.estimate
    rows = np.flatnonzero(log.whole)
    _check_rows(log, rows, offsets=offsets)
    some = _spread(rows, _ROWS)
    tried, least = conventions(log, some, euler, offsets=offsets)
    R, T = tried[0].poses(log, some)
    kept = np.ones(len(some), bool)
    if options.robust:
        tried[0], kept = without_far(R, T, log.lengths[some], tried[0], offsets=offsets)
    best, units = tried[0], units_of(log, tried[0].factor)
    unit, stated = units[0], bool(log.leg_unit or log.place_unit)
    others = tuple((words_of(one, best, log), one.scatter) for one in tried[1:])
    alike = tuple(ambiguous(log, some, tried))
    fits = f"the lengths fit to {best.scatter:.2g} {unit}"
    how = "" if stated else " (by their size: the log names no unit)"
    said = [f"legs in {unit}{how}, positions in {units[1]}", f"{best.turns.words()}: {fits}"]
    said[1] += f"; next best {others[0][0]}: {others[0][1]:.2g} {unit}" if others else ""
    more = [] if offsets else _with_offsets(log, some, euler, best, unit)
    unsure = _ambiguity(alike)
    refused = [f"best: {best.turns.words()}, where {fits}", *more]
    long = float(log.lengths[some].mean())
    if best.scatter > (PRIOR * long if options.prior is None else options.prior):
        raise IncompleteError("\n".join([_NONE, *refused]))
    start = _start(log, best, pivot, unit, offsets=offsets)
    hold = options.hold if offsets else (*options.hold, "offsets")
    seen = _measured(log, best, pivot)
    try:
        result = calibrate_rows(start, seen, sigma, replace(options, hold=hold))
        if not options.hold_unknown:
            _check_only(R[kept], T[kept], log.lengths[some][kept], best, kept, offsets=offsets)
    except IncompleteError as error:
        raise IncompleteError("\n".join([str(error), *refused, *unsure])) from None
    # With few rows linear equations fit so much better by chance.
    gap = _GAP * (1 + _BY_CHANCE / (len(some) - UNKNOWNS - offsets))
    missed = ""
    if best.scatter > gap * least:
        missed = (
            f"lengths fit to {best.scatter:.2g} {unit}, linear equations to {least:.2g}: these are "
            "no legs between two joints, or other joints fit better"
        )
    sentences = (*said, *more, *unsure)
    return Identification(
        result, best.turns, *units, stated, best.scatter, others, alike, offsets, sentences, missed
    )


def _ambiguity(alike: tuple[str, ...]) -> list[str]:
    """Return the sentence of conventions that fit as well, if there are any."""
    if not alike:
        return []
    some = list(alike[:_SHOWN])
    some += [f"{len(alike) - _SHOWN} others"] if len(alike) > _SHOWN else []
    return [
        f"ambiguous: {listed(some, 'and')} fit{'s' if len(some) == 1 else ''} as well: say which "
        "is right, or add poses that turn more, about all axes"
    ]


def _measured(log: Log, best: Convention, pivot: Array) -> Measurements:
    """Return what was measured, in the convention that was found."""
    turned = np.full((len(log.lengths), 3, 3), np.nan)
    whole = np.flatnonzero(np.isfinite(log.turns.reshape(len(turned), -1)).all(axis=1))
    turned[whole] = best.turns.rotations(log, whole)
    return Measurements(log.lengths, turned, log.positions * best.factor, pivot, lines=log.lines)


def _with_offsets(
    log: Log, rows: NDArray[np.intp], euler: str | None, best: Convention, unit: str
) -> list[str]:
    """Return how well lengths fit with a constant of each leg, if that is much better."""
    exact = best.scatter < USUAL * float(log.lengths[rows].mean())
    if exact or len(rows) < UNKNOWNS + 1 + _SPARE:
        return []
    other = conventions(log, rows, euler, offsets=True)[0][0].scatter
    fits = f"with a constant of each leg (--estimate offsets) they fit to {other:.2g} {unit}"
    return [fits] if other * _BETTER < best.scatter else []


def _check_rows(log: Log, rows: NDArray[np.intp], *, offsets: bool) -> None:
    """Raise if there are fewer rows than unknowns of a leg."""
    poses = np.hstack((log.positions, log.turns.reshape(len(log.turns), -1)))[rows]
    places = log.positions[rows]
    if len(rows) and np.ptp(places, axis=0).max() <= _STILL * np.abs(places).max(initial=0.0):
        message = "positions do not change: add poses that move the platform, along x, y and z"
        raise IncompleteError(message)
    found, wanted = len(np.unique(poses, axis=0)), UNKNOWNS + offsets + _SPARE
    if found < wanted:
        raise IncompleteError(
            f"found {counted(found, 'different pose')} with all six lengths, expected at least "
            f"{wanted} to find a machine without a file to start from: add rows, or give SPEC"
        )


def _start(log: Log, best: Convention, pivot: Array, unit: str, *, offsets: bool) -> Instance:
    """Return the machine with the joints found, at the pose of the first whole row."""
    first = np.flatnonzero(log.whole)[:1]
    R, T = best.poses(log, first)
    rows = [
        distance(
            Point((np.array(numbers[:3]) + pivot).tolist()),
            Point(numbers[3:6]),
            length,
            offset=numbers[6] if offsets else None,
        )
        for numbers, length in zip(
            best.joints.tolist(), log.lengths[first[0]].tolist(), strict=True
        )
    ]
    made = instance_of(rows, length=unit, name="Machine found from its log")
    # Products with the factor of units have digits of rounding.
    position, turn = (
        [float(f"{number:.12g}") for number in part[0].tolist()]
        for part in (T - apply(R, pivot), quaternion_from_rotation(R))
    )
    return replace(made, home=HomePose(position, turn))


def _check_only(
    R: Array, T: Array, lengths: Array, best: Convention, kept: NDArray[np.bool_], *, offsets: bool
) -> None:
    """Raise if other joints of a leg explain its lengths as well; found from starts at random."""
    long = float(lengths.mean())
    found, left = fitted(R, T, lengths, random_starts(long), offsets=offsets)
    floor = (EXACT * long) ** 2 * len(lengths)
    squares = np.maximum((left**2).sum(axis=-1), floor)
    least = np.maximum((best.residual[kept] ** 2).sum(axis=0), floor)
    alike = len(lengths) * np.log(squares / least) < LIKELIER
    apart = np.abs(found - best.joints)[..., :6].max(axis=-1) > _DIFFERENT * long
    legs = sorted({int(leg) + 1 for _, leg in np.argwhere(alike & apart)})
    if legs:
        what = "leg" if len(legs) == 1 else "legs"
        raise IncompleteError(
            f"other joints of {what} {listed(map(str, legs), 'and')} explain the log as well: "
            "add poses that move and turn the platform, along and about all axes"
        )
