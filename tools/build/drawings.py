"""Rebuild the drawings of platforms, of joint chains and of a trajectory in docs/images/.

    python -m tools.build.drawings [--check]

What `gsp view -o FILE.svg` and `gsp realize -o FILE.svg` draw. Another version of matplotlib may
write other bytes for the same drawing.
"""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
from pathlib import Path

from gspcli.catalogue.kinds import ALL, DLL, KINDS, Kind
from gspcli.catalogue.realization import REALIZATIONS
from gspcli.cli.main import run
from gspcli.motion import PoseFormat, read_values, track
from gspcli.pictures.chain_panels import chain_drawing
from gspcli.resources import instance_files
from gspcli.spec import load
from tools.build.track_charts import track_chart
from tools.recording import ROOT, parser, save

IMAGES = ROOT / "docs" / "images"
TRAJECTORIES = ROOT / "data" / "trajectories"
DRAWINGS = {
    "example-6.8": ["view", "@example-6.8", "--mode", "57"],
    # The platforms of the paper's Figures 2 to 4 on their chains.
    "figure-14": ["realize", "@figure-2"],
    "figure-15": ["realize", "@figure-3"],
    "figure-16": ["realize", "@figure-4"],
    # A mount from drawing to trajectory.
    "mount-positions": ["workspace", "@rubin-m2", "--over", "x,y,z"],
    "mount-tilts": ["workspace", "@rubin-m2", "--over", "rx,ry"],
    **{
        f"platforms/{name}": ["view", f"@{name}"]
        for name, path in instance_files().items()
        if path.parent.name == "platforms"
    },
}
#: Each constraint in all its realizations; DLL and ALL of the same lines are one more.
CHAINS = [*((kind,) for kind in KINDS), (DLL, ALL)]


def drawn(words: list[str]) -> bytes:
    """Return what a command draws."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drawing.svg"
        with contextlib.redirect_stderr(io.StringIO()):
            code = run([*words, "-o", str(path)])
        if code:
            sys.exit(f"gsp {' '.join(words)} ended with {code}")
        return path.read_bytes()


def loop() -> bytes:
    """Return the chart of the loop of values that leads a mode to another one."""
    instance = load(TRAJECTORIES / "mode-change.yaml")
    text = (TRAJECTORIES / "mode-change.csv").read_text(encoding="utf-8")
    values = read_values(text, "mode-change.csv", instance, PoseFormat()).subdivided(30)
    return track_chart(track(instance, values.values, t=values.t, modes=[2, 1]), "svg")


def chains(kinds: tuple[Kind, ...]) -> bytes:
    """Return the drawing of all realizations of a constraint."""
    names = " and ".join(kind.name for kind in kinds)
    panels = []
    for name, chosen in REALIZATIONS.items():
        made = chosen(*kinds)
        where = f"Figure {made.figure}" if made.figure else name.replace("figure", "inside")
        panels.append((f"{names}, {where}", made))
    return chain_drawing(panels, "svg")


def main() -> int:
    """Write or compare every drawing; return the exit code."""
    arguments = parser(__doc__).parse_args()
    files: dict[Path, str | bytes] = {
        IMAGES / f"{name}.svg": drawn(words) for name, words in DRAWINGS.items()
    }
    files[IMAGES / "mode-change.svg"] = loop()
    for kinds in CHAINS:
        files[IMAGES / f"{'-'.join(kind.name for kind in kinds)}.svg"] = chains(kinds)
    return save(files, check=arguments.check, confirmed=f"{len(files)} drawings")


if __name__ == "__main__":
    sys.exit(main())
