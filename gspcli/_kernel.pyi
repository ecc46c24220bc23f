from typing import Any

import numpy as np
from numpy.typing import NDArray

def centres(points: NDArray[np.float64], *, far: float) -> tuple[NDArray[np.float64], float]: ...
def order(
    real: NDArray[np.bool_],
    quaternions: NDArray[np.complex128],
    translations: NDArray[np.complex128],
    *,
    unit: float,
) -> NDArray[np.int64]: ...
def quotients(ratios: NDArray[np.float64]) -> NDArray[np.float64]: ...
def track(
    products: NDArray[np.bool_],
    start_g: NDArray[np.complex128],
    start_h: NDArray[np.complex128],
    start_tau: NDArray[np.complex128],
    target_g: NDArray[np.complex128],
    target_h: NDArray[np.complex128],
    target_tau: NDArray[np.complex128],
    more_g: NDArray[np.complex128],
    more_h: NDArray[np.complex128],
    more_tau: NDArray[np.complex128],
    points: NDArray[np.complex128],
    low_points: NDArray[np.complex128],
    *,
    left: NDArray[np.float64],
    predictor_tolerance: float,
    contraction: float,
    arrival: float,
    radius_fraction: float,
    min_step: float,
    waypoint: float,
    nearest: float,
    max_steps: int,
    late_steps: int,
    digits: int,
    short_series: bool,
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
    NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128], NDArray[np.float64]
]: ...
def closed_forms(
    u: NDArray[np.float64],
    v: NDArray[np.float64],
    cosines: NDArray[np.float64],
    forms: NDArray[np.float64],
    spheres: int,
    skew: list[int],
    signs: NDArray[np.float64],
    basis: NDArray[np.float64] | None,
    flat: NDArray[np.float64],
    curved: NDArray[np.float64],
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
    equations: int,
    groups: list[list[int]],
    find_distinct: bool,
    max_work: int,
    max_entries: int,
    trace: bool = False,
    moment_relations: bool = True,
    build: str = "",
) -> tuple[int, int, int, list[int], list[int], int, bool, int, tuple[Any, ...] | None]: ...
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
    near: NDArray[np.float64],
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
    NDArray[np.float64],
    NDArray[np.float64],
]: ...
def decide(
    hessians: NDArray[np.float64],
    lows: NDArray[np.float64],
    moduli: NDArray[np.float64],
    equations: NDArray[np.int32],
    weights: NDArray[np.float64],
    turned: NDArray[np.int32],
    values: NDArray[np.float64],
    units: NDArray[np.float64],
    points: NDArray[np.complex128],
    *,
    unit: float,
    origins: NDArray[np.float64],
    scale: float,
    tolerance: float,
    jobs: int = 1,
    build: str = "",
) -> tuple[
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.float64],
    NDArray[np.uint8],
    NDArray[np.uint8],
]: ...
def follow_far(
    numbers: NDArray[np.complex128],
    from_: NDArray[np.complex128],
    to: NDArray[np.complex128],
    local: NDArray[np.complex128],
    *,
    products: int = 0,
    build: str = "",
) -> tuple[NDArray[np.complex128], NDArray[np.uint8]]: ...
def decide_far(
    numbers: NDArray[np.complex128],
    errors: NDArray[np.float64],
    real: NDArray[np.uint8],
    paired: NDArray[np.uint8],
    origin: NDArray[np.complex128],
    starts: NDArray[np.complex128],
    shifts: NDArray[np.float64],
    units: NDArray[np.float64],
    *,
    scale: float,
    tolerance: float,
    products: int = 0,
    jobs: int = 1,
    build: str = "",
) -> tuple[
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.complex128],
    NDArray[np.float64],
    NDArray[np.uint8],
    NDArray[np.uint8],
]: ...

REGULAR: int
NEGATIVE: int
REACH: int

def judge_boxes(
    measures: NDArray[np.int32],
    moduli: NDArray[np.bool_],
    vectors: NDArray[np.float64],
    ranges: NDArray[np.float64],
    legs: NDArray[np.int32],
    of_base: NDArray[np.bool_],
    axes: NDArray[np.float64],
    cosines: NDArray[np.float64],
    turn: NDArray[np.int32],
    *,
    bounds: NDArray[np.float64],
    free: NDArray[np.int32],
    level: int,
    keys: NDArray[np.uint64],
    left: NDArray[np.uint32],
    split: bool,
    jobs: int,
    drives: tuple[
        NDArray[np.int32],
        NDArray[np.bool_],
        NDArray[np.float64],
        NDArray[np.float64],
        NDArray[np.float64],
    ]
    | None = None,
) -> tuple[NDArray[np.uint64], NDArray[np.uint32], NDArray[np.uint64], NDArray[np.uint32]]: ...
def hull_gaps(
    points: NDArray[np.float64], starts: NDArray[np.int64], pairs: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def connected_boxes(
    keys: NDArray[np.uint64],
    levels: NDArray[np.int32],
    dimensions: int,
    touching: bool,
    periodic: NDArray[np.bool_],
    poles: int,
) -> NDArray[np.int64]: ...
def open(
    relations: NDArray[np.int32],
    numbers: NDArray[np.float64],
    tables: NDArray[np.float64],
    *,
    tiny: float,
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.int32],
]: ...
def track_reduced(
    start: NDArray[np.complex128],
    points: NDArray[np.complex128],
    target: NDArray[np.complex128],
    *,
    predictor_tolerance: float,
    contraction: float,
    radius_fraction: float,
    min_step: float,
    max_steps: int,
    lower_rank: bool = False,
    build: str = "",
) -> tuple[NDArray[np.complex128], NDArray[np.uint8]] | None: ...
def track_values(
    pivots: NDArray[np.int32],
    free: NDArray[np.int32],
    forms: NDArray[np.float64],
    slopes: NDArray[np.float64],
    start_values: NDArray[np.complex128],
    starts: NDArray[np.complex128],
    start: NDArray[np.int32],
    values: NDArray[np.complex128],
    *,
    predictor_tolerance: float,
    contraction: float,
    radius_fraction: float,
    min_step: float,
    max_steps: int,
    jobs: int = 1,
    build: str = "",
) -> tuple[
    NDArray[np.complex128], NDArray[np.complex128], NDArray[np.uint8], NDArray[np.int32]
]: ...

class Controller:
    def __init__(
        self, kind: NDArray[np.uint8], either: NDArray[np.uint8], numbers: NDArray[np.float64]
    ) -> None: ...
    def start(self, pose: NDArray[np.float64]) -> int: ...
    def forward(self, values: NDArray[np.float64]) -> int: ...
    def limit(
        self,
        numbers: NDArray[np.float64],
        legs: NDArray[np.uint8],
        on_base: NDArray[np.uint8],
        still: bool,
    ) -> None: ...
    def nearest(self, pose: NDArray[np.float64]) -> int: ...
    def seek(
        self, goal: NDArray[np.float64], start: NDArray[np.float64]
    ) -> tuple[float, NDArray[np.float64]] | None: ...
    def slack(
        self, pose: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def jacobian(self) -> NDArray[np.float64] | None: ...
    def follow_rows(
        self,
        values: NDArray[np.float64],
        pose: NDArray[np.float64],
        near: float,
        shortest: float,
        tries: int,
        keep: bool,
    ) -> tuple[
        int,
        NDArray[np.float64],
        NDArray[np.float64],
        float,
        float,
        float,
        int,
        int,
        float,
        NDArray[np.float64],
    ]: ...
    def report(self) -> tuple[float, float, float, int, int]: ...
    def position(self) -> NDArray[np.float64]: ...
    def rotation(self) -> NDArray[np.float64]: ...
    def values(self) -> NDArray[np.float64]: ...
    def error(self) -> float: ...
