"""Build `data/start-systems/`: solved generic systems of the 119 monomials of six spaces.

Every monomial is solved by monodromy from several seeds, each from its own random system and point;
all seeds must find the same number of solutions and each passes a trace test. The first seed's
solutions are tracked to the systems that are stored. The same command gives the same bytes.

    python -m tools.data.start_systems [--check [--sample N]]
"""

from __future__ import annotations

import io
import json
import sys
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.cli.streams import progress
from gspcli.continuation.quadrics import LETTERS, ComplexArray, random_quadrics
from gspcli.continuation.start import distinct, generic_factors
from gspcli.continuation.systems import EQUATIONS
from tools.data.monodromy import GenericSolutions, move, random_phases, solve_generic
from tools.recording import ROOT, parser, sampled, save, sha256, versions

FOLDER = ROOT / "data" / "start-systems"
SEEDS = (1, 2, 3)


def canonical_monomials() -> list[str]:
    """Return the 119 monomials a^i p^j q^k l^m s^n with i <= 3 and j >= k, sorted by letters."""
    exponents = product(range(4), *[range(EQUATIONS + 1)] * 4)
    chosen = [n for n in exponents if sum(n) == EQUATIONS and n[1] >= n[2]]
    return ["".join(x * k for x, k in zip(LETTERS, n, strict=True)) for n in chosen]


def pack_points(points: ComplexArray) -> NDArray[np.complex64]:
    """Return Study points (n, 8) as stored: divided by e0, without it, in a fixed order."""
    affine = points[:, 1:] / points[:, :1]
    # Keys are rounded, because solutions of some monomials share their rotation.
    keys = np.round(affine.real, 5)
    return affine[np.lexsort(keys.T[::-1])].astype(np.complex64)


def stored_factors(seed: int) -> NDArray[np.complex64]:
    """Return random quadrics in single precision: first and second, by equation and letter."""
    rng = np.random.default_rng([seed, 0])
    rows = [[random_quadrics(LETTERS, rng) for _ in range(EQUATIONS)] for _ in range(2)]
    return np.array(rows).astype(np.complex64)


def solutions_of_stored(
    spaces: str, solved: GenericSolutions, factors: NDArray[np.complex64], rng: np.random.Generator
) -> ComplexArray:
    """Track the solutions of a solved system to the stored system of its spaces."""
    target = generic_factors(factors.astype(np.complex128), spaces)[0]
    for _ in range(5):
        start = solved.quadrics * random_phases(rng, EQUATIONS, 1)
        ends = move(spaces, start, target, solved.points)
        if len(ends) == len(solved.points) and distinct(ends):
            return ends
    message = f"{spaces}: solutions lost on the way to the stored system"
    raise SystemExit(message)


def solved_at_stored(
    spaces: str, number: int, factors: NDArray[np.complex64]
) -> NDArray[np.complex64]:
    """Return the packed solutions of the stored system of six spaces, solved from every seed."""
    solved = [solve_generic(spaces, np.random.default_rng([s, number + 1])) for s in SEEDS]
    found = [len(s.points) for s in solved]
    if len(set(found)) != 1:
        message = f"{spaces}: the seeds {SEEDS} disagree: {found}"
        raise SystemExit(message)
    rng = np.random.default_rng([SEEDS[0], number + 1, 1])
    return pack_points(solutions_of_stored(spaces, solved[0], factors, rng))


def recorded() -> dict[str, NDArray[np.complex64]]:
    """Return the packed solutions on record, by monomial."""
    counts = json.loads((FOLDER / "manifest.json").read_text(encoding="utf-8"))["counts"]
    parts = np.split(np.load(FOLDER / "points.npy"), np.cumsum(list(counts.values()))[:-1])
    return dict(zip(counts, parts, strict=True))


def npy(array: NDArray[np.complex64]) -> bytes:
    """Return the content of an array's file."""
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def main() -> int:
    """Solve, compare, write; return the exit code."""
    arguments = parser(__doc__, sample=True).parse_args()
    monomials = canonical_monomials()
    factors = stored_factors(SEEDS[0])
    chosen = sampled(monomials, arguments.sample if arguments.check else None)
    points = {} if len(chosen) == len(monomials) else recorded()
    for name in progress(chosen, total=len(chosen), label="solving systems"):
        points[name] = solved_at_stored(name, monomials.index(name), factors)
    counts = {name: len(points[name]) for name in monomials}
    packed = np.concatenate([points[name] for name in monomials]).astype(np.complex64)
    files: dict[str, bytes] = {"factors.npy": npy(factors), "points.npy": npy(packed)}
    manifest = {
        "what": "generic systems of six quadrics on the Study quadric with all their solutions",
        "command": "python -m tools.data.start_systems",
        "seeds": list(SEEDS),
        "agreement": "every seed gave every count; every trace test had a defect below 1e-8",
        "versions": versions("numpy"),
        "sha256": {name: sha256(data) for name, data in files.items()},
        "solutions": sum(counts.values()),
        "counts": counts,
    }
    files["manifest.json"] = (json.dumps(manifest, indent=1) + "\n").encode()
    solutions = sum(counts[name] for name in chosen)
    return save(
        {FOLDER / name: data for name, data in files.items()},
        check=arguments.check,
        confirmed=f"{len(chosen)} of {len(monomials)} systems with {solutions} solutions",
    )


if __name__ == "__main__":
    sys.exit(main())
