"""Rebuild the picture of the README that turns: all modes of one hexapod, docs/images/modes.gif.

python -m tools.build.turning_picture [--check]
"""

from __future__ import annotations

import io
import sys

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from gspcli.pictures.figures import BASE, DISTANCE, PLATFORM, SOFT, styled
from gspcli.pictures.line_drawings import draw_body
from gspcli.pictures.projection import Paper, View
from gspcli.pictures.scene import Scene
from gspcli.pictures.staging import scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tools.recording import ROOT, parser, save

PICTURE = ROOT / "docs" / "images" / "modes.gif"
MACHINE = "nano-hexapod"
COLUMNS, ROWS = 4, 2
FRAMES, SECONDS = 36, 9.0
WIDTH, HEIGHT, DPI = 8.0, 3.6, 100
ELEVATION = 22.0
_COLORS = 16


def picture() -> bytes:
    """Return the picture as the content of a file."""
    scene = scene_of(solve(load(instance_files()[MACHINE])))
    frames = [_frame(scene, 360 * k / FRAMES) for k in range(FRAMES)]
    palette = frames[0].quantize(_COLORS)
    fewer = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    content = io.BytesIO()
    still = {"duration": int(1000 * SECONDS / FRAMES), "loop": 0}
    fewer[0].save(content, "GIF", save_all=True, append_images=fewer[1:], **still)
    return content.getvalue()


def _frame(scene: Scene, azimuth: float) -> Image.Image:
    """Return all modes seen from one direction."""
    with styled():
        figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI)
        canvas = FigureCanvasAgg(figure)
        grid = figure.subplots(ROWS, COLUMNS).ravel()
        figure.subplots_adjust(0.005, 0.01, 0.995, 0.93, wspace=0.02, hspace=0.16)
        for mode, axes in enumerate(grid):
            _panel(Paper(axes, View(azimuth, ELEVATION), scene.size), scene, mode)
            axes.set_title(f"mode {mode + 1}", color=SOFT, fontsize=10, pad=2)
        canvas.draw()
        pixels = Image.frombuffer("RGBA", canvas.get_width_height(), canvas.buffer_rgba())
        return pixels.convert("RGB")


def _panel(paper: Paper, scene: Scene, mode: int) -> None:
    modes = scene.series[0]
    draw_body(paper, scene.base, BASE, 0.8, np.eye(3), np.zeros(3), named=False)
    draw_body(paper, scene.platform, PLATFORM, 0.8, modes.R[mode], modes.T[mode], named=False)
    for leg in modes.strokes:
        for stroke in leg:
            paper.line(stroke.points[mode], DISTANCE, 1.8)
    # The same scale in all panels and frames.
    width, low, high = _extent(scene)
    paper.axes.set_xlim(-width, width)
    paper.axes.set_ylim(low, high)
    paper.axes.set_aspect("equal")
    paper.axes.set_axis_off()


def _extent(scene: Scene) -> tuple[float, float, float]:
    """Return half the width, and the lowest and highest coordinate, of all panels and frames."""
    modes = scene.series[0]
    joints = np.array([element.centre for element in scene.platform.elements])
    placed = np.einsum("mij,pj->mpi", modes.R, joints) + modes.T[:, None]
    ends = [element.centre for element in scene.base.elements]
    points = np.concatenate((placed.reshape(-1, 3), ends))
    wide = np.hypot(points[:, 0], points[:, 1])
    tilt = np.radians(ELEVATION)
    up, deep = points[:, 2] * np.cos(tilt), wide * np.sin(tilt)
    return (
        1.04 * float(wide.max()),
        1.04 * float((up - deep).min()),
        1.04 * float((up + deep).max()),
    )


def main() -> int:
    """Write or compare the picture; return the exit code."""
    arguments = parser(__doc__).parse_args()
    return save({PICTURE: picture()}, check=arguments.check, confirmed="a picture that turns")


if __name__ == "__main__":
    sys.exit(main())
