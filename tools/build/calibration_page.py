"""Rebuild what docs/calibrate.md shows: made-up measurements of a real machine, and pictures.

    python -m tools.build.calibration_page [--check]

The machine is `workspace-study-cones`. Its joints are moved and its legs get offsets at random, as
if it had been made to 0.15 mm. The poses are those of ``gsp calibrate --plan`` and some at random.
The readings and the poses there have normal noise of the size that the page states. One reading is
wrong by 0.2 mm, so that there is something to find.

The log of docs/calibrate.md is that of the machine `workspace-study`: 60 poses at random about
home, positions in m, angles in degrees in the order XYZ with rz left-handed, a noise of 2 um.
"""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import gspcli
from gspcli.calibration.candidate_poses import candidates
from gspcli.calibration.parameters import Model
from gspcli.calibration.planning import planned
from gspcli.cli.main import run
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_vector
from gspcli.resources import instance_files
from tools.recording import ROOT, parser, save

SEED = 14
MADE = 0.15
#: Standard deviations: mm of readings and positions, degrees of rotations.
SIGMA = {"value": 0.002, "position": 0.005, "rotation": 0.001}
#: Row and constraint of the reading that is wrong, and by how much (mm).
WRONG = (8, 3, 0.2)
FOLDER = ROOT / "docs" / "calibration"
IMAGES = ROOT / "docs" / "images"
HEAD = "# made up: python -m tools.build.calibration_page\nt,1,2,3,4,5,6,x,y,z,qw,qx,qy,qz\n"


def _home(machine: gspcli.Instance) -> tuple[np.ndarray, np.ndarray]:
    """Return the home pose."""
    result = gspcli.solve(machine)
    assert result.home is not None
    return result.home.R, result.home.T


def _measured(truth: Model, R: np.ndarray, T: np.ndarray, rng: np.random.Generator) -> str:
    """Return a file of what is read and seen at poses."""
    values = measured(truth.bodies(), R, T) - truth.offsets
    values += SIGMA["value"] * rng.normal(size=values.shape)
    if len(values) > WRONG[0] and np.ptp(R, axis=0).max() > 0:
        values[WRONG[0] - 1, WRONG[1] - 1] += WRONG[2]
    turn = rotation_from_vector(np.deg2rad(SIGMA["rotation"]) * rng.normal(size=T.shape))
    R, T = turn @ R, T + SIGMA["position"] * rng.normal(size=T.shape)
    lines = [
        ",".join([str(k), *(f"{x:.4f}" for x in (*row, *place)), *(f"{x:.7f}" for x in q)])
        for k, (row, place, q) in enumerate(
            zip(values, T, quaternion_from_rotation(R), strict=True), 1
        )
    ]
    return HEAD + "\n".join(lines) + "\n"


def _log() -> str:
    """Return a log of a controller: lengths in mm, positions in m, angles with conventions."""
    machine, rng = gspcli.load(instance_files()["workspace-study"]), np.random.default_rng(SEED)
    home, place = _home(machine)
    start = euler_from_rotation("XYZ", home)
    angles = start + rng.uniform(-1, 1, (60, 3)) * np.deg2rad([12, 12, 20])
    T = place + rng.uniform(-1, 1, (60, 3)) * [40, 40, 30]
    lengths = measured(Model.of(machine).bodies(), rotation_from_euler("XYZ", angles), T)
    lengths += SIGMA["value"] * rng.normal(size=lengths.shape)
    written = np.rad2deg(angles) * [1, 1, -1]
    lines = [
        ",".join(
            [
                *(f"{x:.3f}" for x in row),
                *(f"{x / 1000:.6f}" for x in at),
                *map("{:.4f}".format, turn),
            ]
        )
        for row, at, turn in zip(lengths, T, written, strict=True)
    ]
    head = "# made up: python -m tools.build.calibration_page\nL1,L2,L3,L4,L5,L6,X,Y,Z,RX,RY,RZ\n"
    return head + "\n".join(lines) + "\n"


def _picture(*words: str) -> bytes:
    with TemporaryDirectory() as folder, redirect_stdout(io.StringIO()):
        path = Path(folder) / "picture.svg"
        with redirect_stderr(io.StringIO()) as said:
            code = run(["calibrate", "@workspace-study-cones", *words, "-o", str(path)])
        if code:
            raise SystemExit(said.getvalue())
        return path.read_bytes()


def main() -> int:
    """Write the files, or compare them."""
    options = parser(__doc__).parse_args()
    machine = gspcli.load(instance_files()["workspace-study-cones"])
    rng = np.random.default_rng(SEED)
    model = Model.of(machine)
    truth = model.moved(np.where(model.free, MADE * model.sizes * rng.normal(size=60), 0.0))
    R, T = _home(machine)
    plan = planned(machine, 16, R, T, sigma=SIGMA)
    more = candidates(machine, Model.of(machine), R, T, SEED)
    poses = np.concatenate((plan.R, more.R[:8])), np.concatenate((plan.T, more.T[:8]))
    level = T + rng.uniform(-1, 1, (20, 3)) * [10, 10, 8]
    files: dict[Path, str | bytes] = {
        FOLDER / "measured.csv": _measured(truth, *poses, rng),
        FOLDER / "controller-log.csv": _log(),
        FOLDER / "level.csv": _measured(truth, np.broadcast_to(R, (20, 3, 3)), level, rng),
    }
    with TemporaryDirectory() as folder:
        path = Path(folder) / "measured.csv"
        path.write_text(str(files[FOLDER / "measured.csv"]), encoding="utf-8")
        words = [str(path)]
        for name, sigma in SIGMA.items():
            words += ["--sigma", f"{name}={sigma}"]
        files[IMAGES / "calibration-wrong.svg"] = _picture(*words, "--accept")
        files[IMAGES / "calibration-robust.svg"] = _picture(*words, "--robust")
    return save(files, check=options.check, confirmed="the measurements and pictures of the page")


if __name__ == "__main__":
    raise SystemExit(main())
