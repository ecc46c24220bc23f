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
    NDArray[np.float64],
    NDArray[np.uint8],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
]: ...
def build() -> str: ...
