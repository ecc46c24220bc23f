"""What other programs answer to the systems of `programs`, as poses to be certified."""

from __future__ import annotations

import ast
import csv
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import Mistake, SpecError
from gspcli.export.candidates import COMMENTS, CandidatePoses
from gspcli.export.motion_coordinates import DUAL, INVERSE, QUATERNION, ROTATION, TRANSLATION
from gspcli.geometry.quaternions import dot, pose_from_study

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
    middles: Points = array.reshape(len(boxes), -1, 2).mean(axis=2).astype(complex)
    return middles


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
        message = f"{name}: a line has no number for each of {', '.join(names)}"
        raise _unreadable(message) from error
    return names, np.array(numbers, complex).reshape(-1, len(names))


def _names(points: Points, name: str) -> tuple[str, ...]:
    """Return the unknowns of points without names, by their number and what they satisfy."""
    count = points.shape[1]
    if count == len(_RT) or not len(points):
        return _RT
    if count == len(_STUDY):
        on_study = np.abs(dot(points[:, :4], points[:, :4]) - 1) < _TOLERANCE
        return _STUDY if on_study.all() else _AFFINE
    message = f"{name}: found {count} unknowns, expected {len(_STUDY)} or {len(_RT)}"
    raise _unreadable(message)


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
