"""What other programs answer to the systems of `programs`, as poses to be certified."""

from __future__ import annotations

import ast
import csv
import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import Location, Mistake, SpecError
from gspcli.export.polynomial_systems import DUAL, INVERSE, QUATERNION, ROTATION, TRANSLATION
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.quaternions import dot, pose_from_study, rotation_from_quaternion
from gspcli.records import dataclass
from gspcli.wording import shortened

_SHAPES = {"R": (3, 3), "T": (3,), "quaternion": (4,)}
#: Accepted spellings of the columns of a CSV file, by key.
_COLUMNS = {
    "R": [[f"r{i}{j}" for i in "123" for j in "123"], [f"r{i}{j}" for i in "012" for j in "012"]],
    "T": [["tx", "ty", "tz"], ["t1", "t2", "t3"], ["t0", "t1", "t2"], ["x", "y", "z"]],
    "quaternion": [["qw", "qx", "qy", "qz"], ["q0", "q1", "q2", "q3"], ["e0", "e1", "e2", "e3"]],
}
_NUMBERS = tuple("123456")
_SIGNS = {"positive": 1, "negative": -1}
_IMAGINARY_PART = "_imag"
#: Beginnings of lines without poses: comments, and notices of Singular.
COMMENTS = ("#", "//")
_EXPECTED = "R (3x3) or quaternion (4 numbers, scalar first), and T (3 numbers)"


@dataclass(frozen=True)
class CandidatePoses:
    """Poses to be certified."""

    #: Complex, shapes (n, 3, 3) and (n, 3).
    R: NDArray[np.complex128]
    T: NDArray[np.complex128]
    #: Whether the list states that each pose is real, None without a statement.
    claimed_real: tuple[bool | None, ...]
    #: For each pose and constraint the side of its plane that the list says: 1 or -1, or 0 if it
    #: says nothing; shape (n, 6).
    claimed_sides: NDArray[np.int64]


def read_candidates(text: str, name: str, frame: PoseFrame = IDENTITY) -> CandidatePoses:
    """Read a list of poses.

    JSON is a list of poses or an object with one under ``solutions``. A pose is an object with
    ``R`` or ``quaternion`` (scalar first, of any length) and ``T``. A pose that is not real also
    has ``R_imag`` and ``T_imag``. It may state whether it is ``real``, and the ``sides`` of planes,
    such as ``{"1": "positive"}`` (in CSV ``1:positive 2:negative``). A pose may also be a list of
    12 numbers (R by rows, T) or of 7 (quaternion, T).

    CSV has columns r11 ... r33 or qw qx qy qz, and tx ty tz, in any order, with imaginary parts in
    r11_imag and so on; other columns are ignored. Without a heading it has 12 or 7 numbers a line.

    Parameters
    ----------
    text
        The content.
    name
        How error messages name it.
    frame
        The frame of poses whose positions are columns x y z of CSV. All others are those of the
        platform itself.

    Raises
    ------
    SpecError
        With all mistakes in the list.
    """
    entries, where = (
        _json(text, name) if text.lstrip()[:1] in ("[", "{") else _poses_of_csv(text, name)
    )
    if not entries:
        raise _unreadable(f"{name}: found no poses, expected at least one: {_EXPECTED}")
    mistakes: list[Mistake] = []
    poses = []
    for entry, (location, path) in zip(entries, where, strict=True):
        try:
            poses.append(_pose(entry))
        except ValueError as error:
            mistakes.append(Mistake(location, path, str(error)))
    if mistakes:
        raise SpecError(mistakes)
    R = np.array([pose.R for pose in poses], dtype=complex).reshape(-1, 3, 3)
    T = np.array([pose.T for pose in poses], dtype=complex).reshape(-1, 3)
    if not frame.is_identity and _has_positions(text):
        R, T = frame.to_platform(R, T)
    return CandidatePoses(
        R,
        T,
        tuple(pose.claimed_real for pose in poses),
        np.array([pose.claimed_sides for pose in poses], dtype=int).reshape(-1, 6),
    )


def _has_positions(text: str) -> bool:
    """Return whether a text is CSV with columns x, y and z."""
    lines = (line for line in text.splitlines() if line.strip())
    first = next((line for line in lines if not line.lstrip().startswith(COMMENTS)), "")
    return {"x", "y", "z"} <= {cell.strip(' "').lower() for cell in re.split(r"[,;\s]", first)}


Places = list[tuple[Location | None, str]]


def _json(text: str, name: str) -> tuple[list[Any], Places]:
    try:
        # Integers of any length are read as floats, which may be infinite.
        document = json.loads(text, parse_int=float)
    except json.JSONDecodeError as error:
        location = Location(name, error.lineno, error.colno)
        raise SpecError([Mistake(location, "", f"not JSON: {error.msg}")]) from error
    except RecursionError:
        what = "found lists that are nested too deeply, expected a list of poses"
        raise _unreadable(f"{name}: {what}") from None
    is_object = isinstance(document, dict)
    entries = document.get("solutions") if is_object else document
    if not isinstance(entries, list):
        message = f"{name}: found no list under the key solutions, expected one of poses"
        raise SpecError([Mistake(None, "", message)])
    prefix = "solutions" if is_object else ""
    return entries, [(None, f"{name}: {prefix}[{k}]") for k in range(len(entries))]


def _poses_of_csv(text: str, name: str) -> tuple[list[Any], Places]:
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    if not lines:
        return [], []
    first = lines[0][1]
    delimiter = next((mark for mark in ",;\t" if mark in first), " ")
    reader = csv.reader(
        (line.strip() for _, line in lines), delimiter=delimiter, skipinitialspace=True
    )
    rows: list[list[str]] = []
    places: Places = []
    while (begin := reader.line_num) < len(lines):
        # Quotation marks may hold several lines together.
        place = Location(name, lines[begin][0], 1)
        try:
            rows.append([cell.strip() for cell in next(reader)])
        except csv.Error as error:
            raise SpecError([Mistake(place, "", f"found no row of CSV: {error}")]) from error
        places.append((place, ""))
    if all(_is_number(cell) for cell in rows[0]):
        return [list(row) for row in rows], places
    heading = [cell.lower() for cell in rows[0]]
    return [_named(heading, row) for row in rows[1:]], places[1:]


def _named(heading: Sequence[str], row: Sequence[str]) -> dict[str, Any]:
    """Return the pose in a line of a CSV file, keyed as in JSON."""
    cells = dict(zip(heading, row, strict=False))
    pose: dict[str, Any] = {}
    for key, spellings in _COLUMNS.items():
        for suffix in ("", _IMAGINARY_PART):
            for names in spellings:
                values = [cells.get(column + suffix, "") for column in names]
                if any(values):
                    pose[key + suffix] = (
                        values if key != "R" else [values[k : k + 3] for k in (0, 3, 6)]
                    )
                    break
    if claim := cells.get("real", ""):
        pose["real"] = {"true": True, "false": False}.get(claim.lower(), claim)
    if claim := cells.get("sides", ""):
        pose["sides"] = dict(part.partition(":")[::2] for part in claim.split())
    return pose


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


class _Pose(NamedTuple):
    R: NDArray[np.complex128]
    T: NDArray[np.complex128]
    claimed_real: bool | None = None
    claimed_sides: tuple[int, ...] = (0,) * 6


def _pose(entry: object) -> _Pose:
    if isinstance(entry, list):
        if len(entry) not in (7, 12):
            message = f"found {len(entry)} numbers, expected 12 (R by rows, T) or 7 (quaternion, T)"
            raise ValueError(message)
        numbers = _array(entry, (len(entry),), "the list")
        if len(entry) == 7:
            return _Pose(_rotation(numbers[:4]), numbers[4:].astype(complex))
        return _Pose(numbers[:9].reshape(3, 3).astype(complex), numbers[9:].astype(complex))
    if not isinstance(entry, Mapping):
        found = f"{entry:g}" if isinstance(entry, float) else repr(entry)
        raise ValueError(f"found {found}, expected a pose: {_EXPECTED}")
    parts = {
        key + suffix: _array(entry[key + suffix], shape, key + suffix)
        for key, shape in _SHAPES.items()
        for suffix in ("", _IMAGINARY_PART)
        if entry.get(key + suffix) is not None
    }
    rotation = "R" if "R" in parts else "quaternion"
    if rotation not in parts or "T" not in parts:
        found = ", ".join(parts) or "neither"
        raise ValueError(f"found {found}, expected {_EXPECTED}")
    R, T = (
        parts[key].astype(complex) + 1j * parts.get(key + _IMAGINARY_PART, np.zeros(1))
        for key in (rotation, "T")
    )
    claim = entry.get("real")
    if not (claim is None or isinstance(claim, bool)):
        message = f"real: found {shortened(repr(claim))}, expected true or false, or nothing"
        raise ValueError(message)
    sides = _sides(entry.get("sides"))
    return _Pose(R if rotation == "R" else _rotation(R), T, claim, sides)


def _sides(claim: object) -> tuple[int, ...]:
    """Return the side of each constraint that a list says, as a sign, 0 where it says nothing."""
    said = {} if claim is None else claim
    if (
        not isinstance(said, Mapping)
        or not all(number in _NUMBERS for number in said)
        or not all(side in list(_SIGNS) for side in said.values())
    ):
        what = shortened(repr(claim))
        message = f"sides: found {what}, expected positive or negative by numbers of constraints"
        raise ValueError(message)
    return tuple(_SIGNS.get(said.get(number, ""), 0) for number in _NUMBERS)


def _array(value: object, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    try:
        array = np.array(math.nan if _has_truth_values(value) else value, dtype=float)
    except (TypeError, ValueError):
        array = np.array(math.nan)
    if array.shape != shape or not np.isfinite(array).all():
        size = " x ".join(map(str, shape))
        raise ValueError(f"{name} is not {size} finite numbers")
    return array


def _has_truth_values(value: object) -> bool:
    """Whether there is a true or false among numbers, which NumPy takes for one and zero."""
    if isinstance(value, list):
        return any(map(_has_truth_values, value))
    return isinstance(value, bool)


def _rotation(quaternion: NDArray[Any]) -> NDArray[np.complex128]:
    norm = quaternion @ quaternion
    if norm == 0:
        raise ValueError("found a quaternion of norm zero, expected one of a rotation")
    return rotation_from_quaternion(quaternion).astype(complex)


Points = NDArray[np.complex128]

_STUDY, _RT = (*QUATERNION, *DUAL), (*ROTATION, *TRANSLATION)
_AFFINE = (*QUATERNION[1:], *DUAL, INVERSE)
_PHC_SOLUTION = "the solution for t :"
_PHC_COORDINATE = re.compile(r"^ *(\w+) : +(\S+) +(\S+) *$", re.MULTILINE)
_FRACTION = re.compile(r"(-?\d+) / 2\^(\d+)")
#: Relations among the coordinates hold to this, relative to the sizes of their terms.
_TOLERANCE = 1e-6
_IMAGINARY = "_imag"


def read_answer(text: str, name: str) -> CandidatePoses | None:
    """Return the poses in what another program wrote, or None if it is of no known form.

    Known are the output files of msolve (real solutions, as boxes) and of PHCpack, and the CSV
    that the exported scripts print. In Study coordinates with N = 1 each pose occurs twice; one
    of each pair of opposite points is taken.

    Parameters
    ----------
    text
        The content.
    name
        Its name in error messages.

    Raises
    ------
    SpecError
        If the file has a known form but cannot be read.
    """
    stripped = text.strip()
    if _PHC_SOLUTION in text:
        names, points = read_phcpack(text)
        return _candidates(names, points, name)
    if stripped.startswith("[") and stripped.endswith(":"):
        points = read_msolve(stripped, name)
        return _candidates(_names(points, name), points, name, real=True)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith(COMMENTS)]
    heading = lines[0].split(",") if lines else []
    if DUAL[0] in heading:
        names, points = _csv(heading, lines[1:], name)
        return _candidates(names, points, name)
    return None


def read_msolve(text: str, name: str) -> Points:
    """Return the middles of the boxes in msolve's output, shape (n, unknowns).

    Raises
    ------
    SpecError
        If it states anything but isolated solutions.
    """
    # Numerators and denominators have hundreds of digits; their quotients are floats.
    plain = _FRACTION.sub(lambda m: repr(int(m[1]) / 2 ** int(m[2])), text)
    try:
        dimension, *rest = ast.literal_eval(plain.strip().removesuffix(":"))
        if dimension > 0:
            message = f"{name}: msolve found infinitely many solutions, expected isolated ones"
            raise _unreadable(message)
        boxes = rest[0][1] if rest else []
        array = np.array(boxes, float)
    except (ValueError, SyntaxError, TypeError, IndexError) as error:
        message = f"{name}: found a list that ends in a colon, expected the output of msolve"
        raise _unreadable(message) from error
    if not boxes:
        return np.zeros((0, 0), complex)
    return np.asarray(array.reshape(len(boxes), -1, 2).mean(axis=2).astype(complex))


def read_phcpack(text: str) -> tuple[tuple[str, ...], Points]:
    """Return the unknowns and the solutions in PHCpack's format, shape (n, unknowns).

    The list also has each path that was given up, with the last point of it.
    """
    listed = text[text.rfind("THE SOLUTIONS") + 1 :]
    solutions = listed.split(_PHC_SOLUTION)[1:]
    rows = [
        {match[1]: complex(float(match[2]), float(match[3])) for match in found}
        for found in map(_PHC_COORDINATE.finditer, (part.partition("==")[0] for part in solutions))
    ]
    # Unknowns come in the order in which they first occur in the equations.
    names = tuple(sorted(rows[0])) if rows else ()
    return names, np.array([[row[key] for key in names] for row in rows], complex)


def _csv(heading: Sequence[str], lines: Sequence[str], name: str) -> tuple[tuple[str, ...], Points]:
    names = tuple(key for key in heading if not key.endswith(_IMAGINARY))
    try:
        numbers = [
            [complex(float(row[key]), float(row.get(key + _IMAGINARY) or 0)) for key in names]
            for row in csv.DictReader(lines, fieldnames=heading)
        ]
    except (TypeError, ValueError, csv.Error) as error:
        raise _unreadable(f"{name}: a line has no number for each of {', '.join(names)}") from error
    return names, np.array(numbers, complex).reshape(-1, len(names))


def _names(points: Points, name: str) -> tuple[str, ...]:
    """Return the unknowns of points without names, by their number and what they satisfy."""
    count = points.shape[1]
    if count == len(_RT) or not len(points):
        return _RT
    if count == len(_STUDY):
        on_study = np.abs(dot(points[:, :4], points[:, :4]) - 1) < _TOLERANCE
        return _STUDY if on_study.all() else _AFFINE
    raise _unreadable(f"{name}: found {count} unknowns, expected {len(_STUDY)} or {len(_RT)}")


def _candidates(
    names: Sequence[str], points: Points, name: str, *, real: bool | None = None
) -> CandidatePoses:
    known = dict(zip(names, points.T, strict=True)) if len(points) else {}
    if not len(points):
        R, T = np.zeros((0, 3, 3), complex), np.zeros((0, 3), complex)
    elif set(_RT) <= set(names):
        R = np.stack([known[key] for key in ROTATION], axis=1).reshape(-1, 3, 3)
        T = np.stack([known[key] for key in TRANSLATION], axis=1)
    elif {*QUATERNION[1:], *DUAL} <= set(names):
        one = np.ones(len(points), complex)
        full = np.stack([known.get(key, one) for key in _STUDY], axis=1)
        if QUATERNION[0] in known:
            full = full[_first_of_pairs(full)]
        R, T = pose_from_study(full[:, :4], full[:, 4:])
    else:
        message = f"{name}: found the unknowns {' '.join(names)}, expected those of `gsp export`"
        raise _unreadable(message)
    return CandidatePoses(R, T, (real,) * len(R), np.zeros((len(R), 6), int))


def _first_of_pairs(points: Points) -> list[int]:
    """Return the indices of points without those that are the opposite of an earlier one."""
    kept: list[int] = []
    open_: list[int] = []
    for index, point in enumerate(points):
        size = 1 + np.abs(point).max()
        partner = next((k for k in open_ if np.abs(points[k] + point).max() < 1e-8 * size), None)
        if partner is None:
            kept.append(index)
            open_.append(index)
        else:
            open_.remove(partner)
    return kept


def _unreadable(message: str) -> SpecError:
    return SpecError([Mistake(None, "", message)])
