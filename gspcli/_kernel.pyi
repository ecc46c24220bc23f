from typing import Any

import numpy as np
from numpy.typing import NDArray

def track(
    products: NDArray[np.bool_],
    start_g: NDArray[np.complex128],
    start_h: NDArray[np.complex128],
    start_tau: NDArray[np.complex128],
    target_g: NDArray[np.complex128],
    target_h: NDArray[np.complex128],
    target_tau: NDArray[np.complex128],
    points: NDArray[np.complex128],
    *,
    predictor_tolerance: float,
    contraction: float,
    radius_fraction: float,
    min_step: float,
    waypoint: float,
    nearest: float,
    max_steps: int,
    extended: bool,
    jobs: int,
    build: str = "",
) -> tuple[
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.float64],
    NDArray[np.uint8],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
]: ...
def build() -> str: ...
def intersect(
    planes: NDArray[np.complex128],
    quadrics: NDArray[np.complex128],
    accuracy: NDArray[np.float64],
    real: NDArray[np.bool_],
    *,
    build: str = "",
) -> tuple[NDArray[np.complex128], NDArray[np.float64], NDArray[np.bool_]]: ...
def surfaces(
    forms: NDArray[np.float64],
    spheres: int,
    skew: list[int],
    signs: NDArray[np.float64],
    basis: NDArray[np.float64] | None,
    e: NDArray[np.complex128],
    flat: NDArray[np.float64],
    curved: NDArray[np.float64],
) -> tuple[
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.float64],
]: ...
def find_real_points(
    points: NDArray[np.complex128],
) -> tuple[NDArray[np.complex128], NDArray[np.bool_]]: ...
def count(
    prime: int,
    *,
    seed: int,
    blocks: int,
    hessians: NDArray[np.int64],
    moments: NDArray[np.uint64],
    functions: NDArray[np.uint64],
    squares: NDArray[np.uint64],
    weights: NDArray[np.uint64],
    owners: NDArray[np.int64],
    find_distinct: bool,
    max_work: int,
    max_entries: int,
    trace: bool = False,
    build: str = "",
) -> tuple[int, int, int, int, bool, int, tuple[Any, ...] | None]: ...
def follow(
    forms: NDArray[np.int32],
    laws: NDArray[np.int32],
    signs: NDArray[np.float64],
    largest: NDArray[np.float64],
    norms: NDArray[np.float64],
    hessians: NDArray[np.float64],
    spectral: NDArray[np.float64],
    moduli: NDArray[np.float64],
    values: NDArray[np.float64],
    trajectory: NDArray[np.int64],
    start: NDArray[np.float64],
    *,
    certify: bool,
    most_halvings: int,
    jobs: int,
    build: str = "",
) -> tuple[
    NDArray[np.float64],
    NDArray[np.int32],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.float64],
]: ...
