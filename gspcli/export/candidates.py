"""Lists of poses from other programs, as JSON or CSV; nothing in them is taken as proved."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import Location, Mistake, SpecError
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.quaternions import rotation_from_quaternion
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
_IMAGINARY = "_imag"
#: Beginnings of lines without poses: comments, and notices of Singular.
COMMENTS = ("#", "//")
_EXPECTED = "R (3x3) or quaternion (4 numbers, scalar first), and T (3 numbers)"


@dataclass(frozen=True)
class CandidatePoses:
    """Poses to be certified.

    Attributes
    ----------
    R, T
        Complex, shapes (n, 3, 3) and (n, 3).
    claimed_real
        Whether the list states that each pose is real, None without a statement.
    claimed_sides
        For each pose and constraint the side of its plane that the list says: 1 or -1, or 0 if it
        says nothing; shape (n, 6).
    """

    R: NDArray[np.complex128]
    T: NDArray[np.complex128]
    claimed_real: tuple[bool | None, ...]
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
    entries, where = _json(text, name) if text.lstrip()[:1] in ("[", "{") else _csv(text, name)
    if not entries:
        message = f"{name}: found no poses, expected at least one: {_EXPECTED}"
        raise SpecError([Mistake(None, "", message)])
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
        message = f"{name}: found lists that are nested too deeply, expected a list of poses"
        raise SpecError([Mistake(None, "", message)]) from None
    is_object = isinstance(document, dict)
    entries = document.get("solutions") if is_object else document
    if not isinstance(entries, list):
        message = f"{name}: found no list under the key solutions, expected one of poses"
        raise SpecError([Mistake(None, "", message)])
    prefix = "solutions" if is_object else ""
    return entries, [(None, f"{name}: {prefix}[{k}]") for k in range(len(entries))]


def _csv(text: str, name: str) -> tuple[list[Any], Places]:
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
        for suffix in ("", _IMAGINARY):
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
        message = f"found {found}, expected a pose: {_EXPECTED}"
        raise ValueError(message)
    parts = {
        key + suffix: _array(entry[key + suffix], shape, key + suffix)
        for key, shape in _SHAPES.items()
        for suffix in ("", _IMAGINARY)
        if entry.get(key + suffix) is not None
    }
    rotation = "R" if "R" in parts else "quaternion"
    if rotation not in parts or "T" not in parts:
        found = ", ".join(parts) or "neither"
        message = f"found {found}, expected {_EXPECTED}"
        raise ValueError(message)
    R, T = (
        parts[key].astype(complex) + 1j * parts.get(key + _IMAGINARY, np.zeros(1))
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
        message = f"{name} is not {size} finite numbers"
        raise ValueError(message)
    return array


def _has_truth_values(value: object) -> bool:
    """Whether there is a true or false among numbers, which NumPy takes for one and zero."""
    if isinstance(value, list):
        return any(map(_has_truth_values, value))
    return isinstance(value, bool)


def _rotation(quaternion: NDArray[Any]) -> NDArray[np.complex128]:
    norm = quaternion @ quaternion
    if norm == 0:
        message = "found a quaternion of norm zero, expected one of a rotation"
        raise ValueError(message)
    return rotation_from_quaternion(quaternion).astype(complex)
