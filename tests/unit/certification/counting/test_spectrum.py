"""Eigenvectors: those of very different eigenvalues are as precise as others."""

from collections.abc import Iterator
from random import Random

import pytest
from flint import acb, acb_mat, arb, arb_mat, ctx

from gspcli.certification.counting.eigenposes import eigenvectors


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    before = ctx.prec
    ctx.prec = 1024
    yield
    ctx.prec = before


def _matrix(blocks: list[list[list[int]]]) -> arb_mat:
    """Return a matrix similar to one with these blocks of one or two rows."""
    size, random = sum(map(len, blocks)), Random(1)
    rows = [[0] * size for _ in range(size)]
    at = 0
    for block in blocks:
        for i, row in enumerate(block):
            rows[at + i][at : at + len(row)] = row
        at += len(block)
    change = arb_mat([[random.randint(-5, 5) for _ in range(size)] for _ in range(size)])
    return arb_mat((change * arb_mat(rows) * change.inv()).mid())


def _errors(matrix: arb_mat) -> tuple[list[acb], list[float]]:
    """Return the eigenvalues of eigenvectors, and their relative errors."""
    size = matrix.nrows()
    values, errors = [], []
    for vector in eigenvectors(matrix, range(size)):
        image = (acb_mat(matrix) * acb_mat(size, 1, list(vector))).entries()
        k = max(range(size), key=lambda i: float(abs(vector[i] / vector[0]).mid()))
        value = image[k] / vector[k]
        values.append(value)
        wrong = max(abs(x - value * y) for x, y in zip(image, vector, strict=True))
        errors.append(float((wrong / abs(image[k])).mid()))
    return values, errors


@pytest.mark.parametrize("sizes", [(0,), (0, 30, 80), (-100, 60)])
def test_eigenvalues_of_different_sizes(sizes: tuple[int, ...]) -> None:
    """As those of poses 1 and 1e24 lengths away: FLINT finds no roots of their polynomial."""
    blocks, known = [], []
    for size in sizes:
        for k in range(1, 9):
            # A real one, and a pair of conjugates.
            unit = arb(2) ** size
            blocks += [[[k * unit]], [[k * unit, -3 * unit], [3 * unit, k * unit]]]
            known += [k * unit, acb(k * unit, 3 * unit), acb(k * unit, -3 * unit)]
    values, errors = _errors(_matrix(blocks))
    assert len(values) == len(known)
    assert max(errors) < 1e-60
    for exact in map(acb, known):
        assert sum(abs(x - exact) < abs(exact) * arb(1e-40) for x in values) == 1
