"""Rebuild the moving picture of the README, docs/images/live.webp: a live page that is dragged.

    python -m tools.build.live_picture [--check]

Headless Chromium opens the page of `gsp view --live` of a hexapod; a pointer drags a leg until
modes meet and vanish, and back, and then both values of the map. Pictures of a browser differ from
machine to machine: with --check it is compared what the kept one was made of, which is written in
it.
"""

from __future__ import annotations

import io
import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from PIL import Image, ImageDraw

from gspcli.pictures.live_numbers import live_numbers
from gspcli.pictures.live_page import live_page
from gspcli.pictures.staging import scene_of
from gspcli.resources import data_path, instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tools.browser import CHROMIUM, PATIENCE, Browser
from tools.recording import ROOT, UNABLE, parser, save, sha256

PICTURE = ROOT / "docs" / "images" / "live.webp"
MACHINE = "workspace-study"
WIDTH, HEIGHT, SCALE = 1240, 820, 0.75
#: Milliseconds of a frame, and of the last.
FRAME, LAST = 140, 1600
QUALITY = 60
#: Where the pointer goes: in parts of the first slider, and of the map from its lower left corner.
_SLIDER = [0.518 - 0.009 * k for k in range(18)]
_MAP = [(0.518 + 0.02 * k, 0.518 + 0.03 * min(k, 11) - 0.05 * max(k - 11, 0)) for k in range(20)]
_BOX = "(({x, y, width, height}) => [x, y, width, height])(%s.getBoundingClientRect())"

Place = tuple[float, float]


def made_of() -> str:
    """Return a hash of what the picture is made of: page, kernel, machine and way."""
    parts = [
        data_path("view", "live.html").read_text(encoding="utf-8"),
        sha256(data_path("live", "kernel.wasm.gz").read_bytes()),
        instance_files()[MACHINE].read_text(encoding="utf-8"),
        json.dumps([WIDTH, HEIGHT, SCALE, _SLIDER, _MAP]),
    ]
    return sha256("\n".join(parts))


def way(browser: Browser) -> Iterator[tuple[Place, bool]]:
    """Yield where the pointer is, and whether it is pressed."""
    left, top, width, height = browser.run(_BOX % "document.querySelector('#values [type=range]')")
    along = [(left + part * width, top + height / 2) for part in [*_SLIDER, *_SLIDER[::-1]]]
    yield along[0], False
    yield from ((place, True) for place in along)
    yield along[-1], False
    left, top, width, height = browser.run(_BOX % "document.getElementById('map')")
    across = [(left + x * width, top + (1 - y) * height) for x, y in _MAP]
    (x0, y0), (x1, y1) = along[-1], across[0]
    yield from (((x0 + t * (x1 - x0), y0 + t * (y1 - y0)), False) for t in (0.25, 0.5, 0.75))
    yield from ((place, True) for place in across)
    yield across[-1], False


def frames(browser: Browser, page: Path) -> Iterator[Image.Image]:
    """Yield the pictures of the page while it is dragged."""
    browser.size(WIDTH, HEIGHT)
    browser.open(page)
    browser.wait("document.getElementById('map').dataset.filled === 'true'", 10 * PATIENCE)
    before = False
    for (x, y), pressed in way(browser):
        button = {"button": "left", "clickCount": 1}
        if pressed != before:
            browser.mouse("mousePressed" if pressed else "mouseReleased", x, y, **button)
        else:
            browser.mouse(
                "mouseMoved", x, y, **({"button": "left", "buttons": 1} if pressed else {})
            )
        before = pressed
        browser.settle()
        picture = Image.open(io.BytesIO(browser.screenshot())).convert("RGB")
        # Scaled here: a browser that scales draws half a pixel of rows above the header of a table.
        picture = picture.resize(
            (round(WIDTH * SCALE), round(HEIGHT * SCALE)), Image.Resampling.LANCZOS
        )
        yield _with_pointer(picture, x * SCALE, y * SCALE, pressed=pressed)


def _with_pointer(picture: Image.Image, x: float, y: float, *, pressed: bool) -> Image.Image:
    """Return the picture with an arrow where the pointer is."""
    arrow = [(0, 0), (0, 17), (4, 13.5), (6.5, 19), (9, 18), (6.5, 12.5), (12, 12)]
    fill = "#c0246f" if pressed else "#ffffff"
    ImageDraw.Draw(picture).polygon([(x + a, y + b) for a, b in arrow], fill, "#000000")
    return picture


def picture() -> bytes:
    """Return the picture as the content of a file."""
    result = solve(load(instance_files()[MACHINE]))
    assert result.home is not None
    text = live_page(scene_of(result), live_numbers(result), result.home.number - 1, names=False)
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "live.html"
        page.write_text(text, encoding="utf-8")
        browser = Browser(Path(folder) / "profile")
        try:
            shown = list(frames(browser, page))
        finally:
            browser.close()
    content = io.BytesIO()
    still = {"duration": [FRAME] * (len(shown) - 1) + [LAST], "loop": 0}
    how = {"quality": QUALITY, "method": 6, "minimize_size": True, "xmp": made_of().encode()}
    shown[0].save(content, "WEBP", save_all=True, append_images=shown[1:], **still, **how)
    return content.getvalue()


def kept() -> bytes:
    """Return what the kept picture was made of."""
    with Image.open(PICTURE) as found:
        return bytes(found.info.get("xmp", b""))


def main() -> int:
    """Write the picture or compare what it was made of; return the exit code."""
    arguments = parser(__doc__).parse_args()
    if arguments.check:
        is_same = PICTURE.exists() and kept() == made_of().encode()
        print("confirmed: the moving picture" if is_same else f"{PICTURE.name} is of another page")
        return 0 if is_same else 1
    if CHROMIUM is None:
        print("the moving picture cannot be made without chromium")
        return UNABLE
    return save({PICTURE: picture()}, check=False, confirmed="the moving picture")


if __name__ == "__main__":
    sys.exit(main())
