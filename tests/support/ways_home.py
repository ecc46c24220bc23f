"""Ways home as live pages find them, by their program in Node."""

from __future__ import annotations

import json
import subprocess
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.pictures.live_numbers import live_module, live_numbers
from gspcli.pictures.stage import first_mode, scene_of
from gspcli.solver.result import SolveResult
from tools.recording import ROOT

Array = NDArray[np.float64]
PROGRAM = ROOT / "viewer" / "ways.mjs"


def ways_home(
    result: SolveResult, R: Array, T: Array, live: dict[str, Any] | None = None
) -> list[dict[str, Any]]:
    """Return what a live page finds from poses: kind or reason, and rows (R, T, values)."""
    modes = result.R[result.real].real, result.T[result.real].real
    given = {
        "module": live_module(),
        "live": live_numbers(result) if live is None else live,
        "size": scene_of(result).size,
        "start": first_mode(result),
        "modes": _flat(*modes),
        "poses": _flat(R, T),
    }
    run = subprocess.run(
        ["node", str(PROGRAM)], input=json.dumps(given), capture_output=True, text=True, check=True
    )
    found: list[dict[str, Any]] = json.loads(run.stdout)["found"]
    return found


def _flat(R: Array, T: Array) -> list[list[float]]:
    return np.concatenate((R.reshape(-1, 9), T), axis=1).tolist()
