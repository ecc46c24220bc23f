"""The native kernel against the same mathematics written plainly in NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.endpoints import random_start
from gspcli.continuation.quadrics import random_quadrics
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import Structure, System
from gspcli.continuation.tracker import PathStatus, track


def quadric(q, z):
    """Value and gradient of one quadric, written out from the definition of its coefficients."""
    e, f = z[:4], z[4:]
    value, gradient, k = 0.0, np.zeros(8, dtype=complex), 0
    for i in range(4):
        for j in range(i, 4):
            value += q[k] * e[i] * e[j]
            gradient[i] += q[k] * e[j]
            gradient[j] += q[k] * e[i]
            k += 1
    for i in range(4):
        for j in range(4):
            value += q[k] * e[i] * f[j]
            gradient[i] += q[k] * f[j]
            gradient[4 + j] += q[k] * e[i]
            k += 1
    value += q[k] * (f @ f)
    gradient[4:] += 2 * q[k] * f
    return value, gradient


def system(products, start, target, z, t):
    """Values, Jacobian matrix with the row of the moving patch, and derivative in t."""
    rows, values, rates = [np.r_[z[4:], z[:4]]], [z[:4] @ z[4:]], [0.0]
    n = z[:4] @ z[:4]
    dn = np.r_[2 * z[:4], np.zeros(4)]
    for i in range(6):
        g, dg = quadric((1 - t) * start.g[i] + t * target.g[i], z)
        g_rate = quadric(target.g[i] - start.g[i], z)[0]
        if not products[i]:
            values, rows, rates = [*values, g], [*rows, dg], [*rates, g_rate]
            continue
        h, dh = quadric((1 - t) * start.h[i] + t * target.h[i], z)
        h_rate = quadric(target.h[i] - start.h[i], z)[0]
        tau, tau_rate = (1 - t) * start.tau[i] + t * target.tau[i], target.tau[i] - start.tau[i]
        values.append(g * h - tau * n**2)
        rows.append(g * dh + h * dg - 2 * tau * n * dn)
        rates.append(g_rate * h + g * h_rate - tau_rate * n**2)
    jacobian = np.array([*rows, z.conj()])
    return np.array([*values, 0.0]), jacobian, np.array([*rates, 0.0])


def follow(products, start, target, z, tolerance=1e-8):
    """Fourth-order Runge-Kutta steps of adaptive length, each corrected by Newton's method."""
    t, step = 0.0, 0.01
    z = z / np.linalg.norm(z)

    def slope(x, s):
        _, jacobian, rate = system(products, start, target, x, s)
        return -np.linalg.solve(jacobian, rate)

    while t < 1:
        step = min(step, 1 - t)
        k1 = slope(z, t)
        k2 = slope(z + step / 2 * k1, t + step / 2)
        k3 = slope(z + step / 2 * k2, t + step / 2)
        k4 = slope(z + step * k3, t + step)
        x = z + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        sizes = []
        for _ in range(3):
            values, jacobian, _ = system(products, start, target, x, t + step)
            change = np.linalg.solve(jacobian, values)
            x, sizes = x - change, [*sizes, np.linalg.norm(change)]
        if sizes[0] < tolerance * 1e3 and sizes[2] < tolerance:
            z, t = x / np.linalg.norm(x), 1.0 if t + step >= 1 else t + step
            step *= 1.5 if sizes[0] < tolerance * 1e2 else 1.0
        else:
            step /= 2
            assert step > 1e-9
    return z


@pytest.mark.parametrize(
    ("spaces", "products", "paths"),
    [("ssssss", "000000", 4), ("apqlss", "000000", 3), ("apqlss", "011100", 3)],
)
def test_kernel_against_reference(spaces, products, paths):
    structure = Structure(spaces, tuple(x == "1" for x in products)).canonical()
    mask = np.array(structure.products)
    rng = np.random.default_rng(13)
    start = start_system(structure)
    origin = random_start(start, 14, 0)
    g, h = (random_quadrics(structure.spaces, rng) for _ in range(2))
    target = System.of(structure, g, h, np.where(mask, 0.2 + 0.1j, 0))
    points = start.points[rng.choice(len(start.points), paths, replace=False)]
    results = track(origin, target, points)
    assert (results.status == PathStatus.REGULAR).all()
    for point, end in zip(points, results.points[0], strict=True):
        reference = follow(mask, origin.coefficients, target.coefficients, point)
        assert abs(np.vdot(reference, end)) > 1 - 1e-12


def test_condition_against_singular_values():
    start = start_system(Structure("ssssss"))
    origin = random_start(start, 15, 0)
    mask = np.zeros(6, dtype=bool)
    results = track(origin, origin, start.points)
    for point, condition in zip(results.points[0], results.condition[0], strict=True):
        jacobian = system(mask, origin.coefficients, origin.coefficients, point, 0.0)[1][:7]
        values = np.linalg.svd(jacobian, compute_uv=False)
        assert condition == pytest.approx(np.sqrt((values**-2.0).sum()), rel=1e-6)
