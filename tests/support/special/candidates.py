"""`gsp certify` on the poses of special platforms, as `gsp solve` prints them, and on wrong ones.

What is right follows from the list of all poses: certified if one of them is within the
tolerance, refuted only if none is. A pose must not be counted twice, nor be real or not against
what is known of it.
"""

from __future__ import annotations

import io
import json
import tempfile
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli import dumps
from gspcli.certification.equations.local_frames import FAR, LocalFrames
from gspcli.cli.main import run
from gspcli.defaults import SEED, TOLERANCE
from gspcli.errors import IncompleteError
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, vector
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.solver import SolveResult, solve
from tests.support.special.platforms import Draws, Platform

Complex = NDArray[np.complex128]
#: What may be said: nothing is claimed of what is undecided.
HONEST = ("right", "undecided")
#: This many poses are changed; all are certified without a change, too.
_CHANGED = 3
#: By how much, as powers of ten of the platform's size.
_POWERS = (-9, -7, -6, -5, -3)
#: How far away the base is put, in typical lengths.
_AWAY = 10**7
#: Within this part of the tolerance a pose must not be refuted, and beyond that it must not be
#: certified: the poses on the list are rounded.
_WITHIN, _BEYOND = 0.9, 1.1
#: Complex rotations with larger entries are next to isotropic vectors: their doubles do not say
#: any longer which solution they are.
_FAR = 1e8
#: A few roundings.
_ROUNDINGS = 4 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class Candidate:
    """A pose to be certified.

    Attributes
    ----------
    name
        How it was made.
    R, T
        The pose, shapes (3, 3) and (3,).
    real
        What is claimed of it, if anything.
    """

    name: str
    R: Complex
    T: Complex
    real: bool | None = None

    def to_json(self) -> dict[str, Any]:
        """Return it as `gsp solve` prints poses."""
        entry: dict[str, Any] = {"R": self.R.real.tolist(), "T": self.T.real.tolist()}
        if self.R.imag.any() or self.T.imag.any():
            entry |= {"R_imag": self.R.imag.tolist(), "T_imag": self.T.imag.tolist()}
        return entry if self.real is None else {**entry, "real": self.real}


class _Poses:
    """All poses of a platform, with distances as `certify` has them."""

    def __init__(self, solved: SolveResult, scale: float, least: float) -> None:
        self.R, self.T = solved.R, solved.T
        origin = LocalFrames.of(solved.instance)
        self.platform = np.array([float(x) for x in origin.platform])
        self.base = np.array([float(x) for x in origin.base])
        self.scale, self.least = scale, least

    def distances(self, pose: Candidate) -> tuple[NDArray[np.float64], float]:
        """Return how far a candidate is from each pose, and the tolerance there."""
        turned, moved = self.R - pose.R, self.T - pose.T
        moved = (moved + turned @ self.platform) / self.scale
        entries = (pose.T + pose.R @ self.platform - self.base) / self.scale
        size = max(1.0, float(np.abs(pose.R).max()), float(np.abs(entries).max()))
        length = 1.0 if np.abs(entries).max() > FAR else self.least / self.scale
        far = np.maximum(np.abs(turned).max(axis=(1, 2)), np.abs(moved).max(axis=1) / length)
        return far, TOLERANCE * size


def attacked(platform: Platform) -> tuple[str, list[tuple[str, str, str]]]:
    """Return the statements about candidates for a platform.

    Returns
    -------
    name, remarks
        The platform; and for each candidate how it was made, ``right``, ``undecided`` or what is
        wrong, and what was said.
    """
    try:
        remarks = _attacked(platform.instance, Draws(f"{SEED} candidates {platform.id}"))
        away = _put_away(platform.instance)
        remarks += [
            (f"base far away, {name}", verdict, said)
            for name, verdict, said in _attacked(
                away, Draws(f"{SEED} far candidates {platform.id}")
            )
        ]
    except Exception as error:
        remarks = [("all", "failed", repr(error)[:200])]
    return platform.id, remarks


def _attacked(instance: Instance, draws: Draws) -> list[tuple[str, str, str]]:
    solved = solve(instance, seed=SEED)
    simple = np.flatnonzero(solved.certified)
    if not len(simple):
        return []
    with tempfile.TemporaryDirectory() as folder:
        spec = Path(folder) / "platform.yaml"
        spec.write_text(dumps(instance), encoding="utf-8")
        printed = solved.to_json(everything=True)
        printed["solutions"] = [printed["solutions"][k] for k in simple]
        code, answer = certified(spec, json.dumps(printed))
        remarks = list(_all_right(code, answer, solved, simple.tolist()))
        poses = _Poses(solved, answer["scale"], answer["least_length"])
        changed = draws.sample(simple.tolist(), min(len(simple), _CHANGED))
        for name, candidates in _lists(solved, changed, answer["scale"], draws).items():
            text = json.dumps({"solutions": [c.to_json() for c in candidates]})
            code, answer = certified(spec, text)
            remarks += _judged(name, code, candidates, answer["solutions"], poses, solved)
    return remarks


def certified(spec: Path, text: str) -> tuple[int, dict[str, Any]]:
    """Return the exit code of `gsp certify` for a list of poses, and what it prints as JSON."""
    poses = spec.with_name("poses.json")
    poses.write_text(text, encoding="utf-8")
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(io.StringIO()):
        code = run(["certify", str(spec), str(poses), "--format", "json"])
    document: dict[str, Any] = json.loads(out.getvalue())
    return code, document


def _all_right(
    code: int, answer: dict[str, Any], solved: SolveResult, poses: Sequence[int]
) -> list[tuple[str, str, str]]:
    """Judge the statements about all certified poses as printed."""
    for k, item in enumerate(answer["solutions"]):
        agrees = item["real"] == item["claimed_real"] and item["same_as"] is None
        if not item["certified"] or not agrees or item["unresolved"]:
            said = {key: item[key] for key in ("outcome", "real", "same_as", "unresolved")}
            others = [poses[number - 1] for number in item["unresolved"]]
            unclear = _is_far(solved, poses[k]) or _are_one_in_doubles(solved, poses[k], others)
            is_open = unclear and code == IncompleteError.exit_code
            verdict = "undecided" if is_open else "not certified"
            return [("as printed", verdict, f"pose {k + 1}: {said}, exit {code}")]
    return [("as printed", "right" if code == 0 else "wrong exit code", f"exit {code}")]


def _is_far(solved: SolveResult, pose: int) -> bool:
    return bool(np.abs(solved.R[pose]).max() > _FAR)


def _are_one_in_doubles(solved: SolveResult, pose: int, others: Sequence[int]) -> bool:
    """Whether other poses are nearer to one than its translation can be written in doubles."""
    length = solved.arrangement.length
    error = _ROUNDINGS * max(1.0, float(np.abs(solved.T[pose]).max()) / length)
    turned = np.abs(solved.R[others] - solved.R[pose]).max(initial=0)
    moved = np.abs(solved.T[others] - solved.T[pose]).max(initial=0) / length
    return bool(others) and bool(max(turned, moved) < error)


def _lists(
    solved: SolveResult, changed: Sequence[int], scale: float, draws: Draws
) -> dict[str, list[Candidate]]:
    """Return lists of candidates by what is done to correct poses."""
    own = [Candidate("own", solved.R[k], solved.T[k], bool(solved.real[k])) for k in changed]
    found: dict[str, list[Candidate]] = {"moved": [], "turned": []}
    for power in _POWERS:
        step = scale * 10.0**power
        for pose in own:
            shift, turn = (np.array([float(draws.decimal(1, 9)) for _ in range(3)]) for _ in "TR")
            T = pose.T + step * shift / np.abs(shift).max()
            found["moved"].append(replace(pose, name=f"moved by 1e{power}", T=T, real=None))
            R = rotation_from_vector(10.0**power * turn) @ pose.R
            found["turned"].append(replace(pose, name=f"turned by 1e{power}", R=R, real=None))
    found["exchanged"] = [
        Candidate("rotation of one, translation of another", first.R, second.T)
        for first, second in pairwise(own)
    ]
    found["twice"] = [*own, *own]
    found["conjugate"] = [
        Candidate("conjugate", pose.R.conj(), pose.T.conj(), False) for pose in own if not pose.real
    ]
    found["claimed wrongly"] = [replace(own[0], real=not own[0].real)]
    found["imaginary parts dropped"] = [
        Candidate("real parts", pose.R.real.astype(complex), pose.T.real.astype(complex))
        for pose in own
        if not pose.real
    ]
    nearby = _of_another_sheet(solved, draws)
    found["other values"] = [Candidate("other values", R, T) for R, T in nearby]
    return {name: candidates for name, candidates in found.items() if candidates}


def _of_another_sheet(solved: SolveResult, draws: Draws) -> list[tuple[Complex, Complex]]:
    """Return poses of the same geometry with one value a little larger."""
    rows = solved.instance.constraints
    index = draws.choice([k for k, row in enumerate(rows) if row.kind.is_distance])
    value = rows[index].value
    other = Number.of(value.value * (1 + 10.0 ** -draws.randint(3, 7)))
    found = solve(solved.instance.with_values({index: other}), seed=SEED)
    return list(zip(found.R[:_CHANGED], found.T[:_CHANGED], strict=True))


def _judged(
    name: str,
    code: int,
    candidates: Sequence[Candidate],
    items: Sequence[dict[str, Any]],
    poses: _Poses,
    solved: SolveResult,
) -> list[tuple[str, str, str]]:
    """Judge the statements about a list of candidates."""
    remarks = []
    first: dict[int, int] = {}
    wrong = False
    for number, (candidate, item) in enumerate(zip(candidates, items, strict=True), 1):
        far, tolerance = poses.distances(candidate)
        nearest = int(far.argmin())
        said = f"{item['outcome']}, real {item['real']}; nearest pose at {far[nearest]:.3g}"
        verdict = "right"
        if item["certified"]:
            close = np.flatnonzero(far <= _BEYOND * tolerance)
            alone = len(close) == 1 and solved.certified[close[0]]
            if not len(close):
                verdict = "no pose" if solved.verdict == "complete" else "right"
            elif alone and item["real"] is not None and item["real"] != solved.real[close[0]]:
                verdict = "wrong real"
            elif alone and first.setdefault(int(close[0]), number) != number:
                repeated = item["same_as"] == first[int(close[0])]
                verdict = "right" if repeated or item["unresolved"] else "counted twice"
                wrong |= repeated
            wrong |= candidate.real is not None and item["real"] is (not candidate.real)
        elif item["outcome"] in ("refuted", "not as stated"):
            wrong = True
            if far[nearest] <= _WITHIN * tolerance and solved.certified[nearest]:
                verdict = "false refutation"
        elif far[nearest] <= _WITHIN * tolerance:
            verdict = "undecided"
        remarks.append((candidate.name, verdict, said))
    if wrong and code != 1:
        remarks.append((name, "wrong exit code", f"exit {code}"))
    near = all(np.abs(candidate.R).max() < _FAR for candidate in candidates)
    if name == "conjugate" and code and (near or code != IncompleteError.exit_code):
        remarks.append((name, "wrong exit code", f"exit {code}"))
    return remarks


def _put_away(instance: Instance) -> Instance:
    """Return the instance with its base many lengths away, exactly."""
    distances = [abs(c.value.value) for c in instance.constraints if c.kind.is_distance]
    step = _AWAY * max(1, round(max(distances)))
    shift = [Fraction(step * k) for k in (1, -2, 1)]

    def moved(geometry: Geometry) -> Geometry:
        return replace(
            geometry,
            position=vector(
                *(
                    Number("+", (x, Number.of(s))) if x.fraction is None else x.fraction + s
                    for x, s in zip(geometry.position, shift, strict=True)
                )
            ),
        )

    def row(constraint: Constraint) -> Constraint:
        return replace(constraint, base=moved(constraint.base))

    return replace(instance, constraints=tuple(map(row, instance.constraints)))
