"""Verify that live pages draw what ordinary pages draw.

    python -m tools.verify.live_pictures [NAME ...] [--keep FOLDER]

Each shipped platform is opened in headless Chromium as the page of `gsp view` and as that of
`gsp view --live`. In every assembly mode both must draw the same picture, from the same view and in
the same colours, without other modes and names. Modes that are drawn differently are named, and
the exit code is then 1; with ``--keep`` both pictures of such a mode are written to a folder.
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from gspcli.errors import GspError
from gspcli.pictures.live_numbers import live_numbers
from gspcli.pictures.live_page import live_page
from gspcli.pictures.page import page
from gspcli.pictures.staging import first_mode, scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tools.browser import CHROMIUM, Browser
from tools.recording import CONFIRMED, DIFFERENT, UNABLE

Pixels = NDArray[np.int16]

WIDTH, HEIGHT = 640, 480
#: Pixels are other ones if a colour differs by more, of 255. Strokes that the page computes differ
#: from those that are written in it by rounding to the decimals of a scene.
SHADE = 64
#: This many of such pixels are the edges of the same parts. A right-angle mark without one of its
#: strokes has more.
FEW = 6
#: A picture of nothing has no more shades.
EMPTY = 3
#: The picture alone, of one size on both pages.
_STYLE = f"""
  .stage {{ position: fixed !important; z-index: 9; left: 0; top: 0; display: block !important;
    width: {WIDTH}px !important; height: {HEIGHT}px !important; min-height: 0 !important; }}
  .stage > :not(canvas) {{ display: none !important; }}
  .stage > canvas {{ width: {WIDTH}px !important; height: {HEIGHT}px !important; }}
"""
_ALONE = f"""
(() => {{
  const style = document.createElement("style");
  style.textContent = {_STYLE!r};
  document.head.append(style);
  const root = document.documentElement;
  const blue = getComputedStyle(root).getPropertyValue("--platform");
  for (let k = 0; k < 12; k += 1) root.style.setProperty(`--mode-${{k}}`, blue);
  const set = (id, value) => {{
    const control = document.getElementById(id);
    if (!control) return;
    if (control.type === "checkbox") control.checked = value === "true";
    else control.value = value;
    control.dispatchEvent(new Event("change"));
  }};
  set("theme", "light");
  set("ghosts", "false");
  set("others", "none");
  set("names", "false");
}})()
"""
_FOLLOW = {
    "ordinary": "document.querySelectorAll('#modes tbody button')[{0} - 1].click()",
    "live": "document.querySelector('#modes [data-mode=\"{0}\"] button').click()",
}
_LISTED = (
    "[...document.querySelectorAll('#modes [data-mode]')].map((row) => Number(row.dataset.mode))"
)
_WHOLE = "document.querySelector('[data-view=reset]').click()"


def pages(name: str, folder: Path) -> dict[str, Path] | None:
    """Write both pages of a shipped platform and return the files; None if it has no live one."""
    result = solve(load(instance_files()[name]))
    try:
        numbers = live_numbers(result)
    except GspError:
        return None
    scene, start = scene_of(result), first_mode(result)
    texts = {"ordinary": page(scene, start), "live": live_page(scene, numbers, start)}
    paths = {}
    for kind, text in texts.items():
        paths[kind] = folder / f"{name}-{kind}.html"
        paths[kind].write_text(text, encoding="utf-8")
    return paths


def opened(browser: Browser, kind: str, path: Path) -> None:
    """Open a page of a kind, and show nothing but the picture of one mode."""
    browser.size(WIDTH + 400, HEIGHT + 200)
    browser.call("Page.navigate", url="about:blank")
    browser.open(path)
    if kind == "live":
        browser.wait("document.documentElement.dataset.ready === 'true'")
    browser.run(_ALONE)
    browser.settle()


def pictures(browser: Browser, kind: str, modes: Sequence[int]) -> list[Pixels]:
    """Return the picture of each mode on the page that is open, shape (height, width, 3)."""
    clip = {"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT, "scale": 1}
    found = []
    for mode in modes:
        browser.run(_FOLLOW[kind].format(mode))
        browser.run(_WHOLE)
        browser.settle()
        with Image.open(io.BytesIO(browser.screenshot(clip))) as image:
            found.append(np.asarray(image.convert("RGB"), np.int16))
    return found


def other_pixels(one: Pixels, two: Pixels) -> int:
    """Return how many pixels of two pictures have a colour that the other has not there.

    The colour of a pixel of the other, or of one beside it, counts: rods that touch are drawn in
    the order of rounding errors.
    """
    return max(_without_partner(one, two), _without_partner(two, one))


def _without_partner(one: Pixels, two: Pixels) -> int:
    near = [np.roll(two, (x, y), axis=(0, 1)) for x in (-1, 0, 1) for y in (-1, 0, 1)]
    differences = np.min([np.abs(one - other).max(axis=2) for other in near], axis=0)
    return int((differences > SHADE).sum())


def compared(
    browser: Browser,
    name: str,
    folder: Path,
    most: int | None = None,
    keep: Callable[[str, Pixels, Pixels], None] | None = None,
) -> dict[int, int] | None:
    """Compare the pictures of a shipped platform on both pages.

    Parameters
    ----------
    browser, name, folder
        Where both pages are opened, of which platform, and where they are written.
    most
        This many modes, spread over all of them; every mode if None.
    keep
        Gets a name and both pictures of a mode whose pictures differ.

    Returns
    -------
    dict
        How many pixels differ, by the number of the mode, of those that both pages list: a live
        page lists poses that it proves. None if there is no live page.
    """
    paths = pages(name, folder)
    if paths is None:
        return None
    opened(browser, "live", paths["live"])
    listed = browser.run(_LISTED)
    modes = listed[:: 1 if most is None else max(1, -(-len(listed) // most))]
    live = pictures(browser, "live", modes)
    assert not browser.messages, browser.messages
    opened(browser, "ordinary", paths["ordinary"])
    ordinary = pictures(browser, "ordinary", modes)
    found = {}
    for mode, one, two in zip(modes, ordinary, live, strict=True):
        assert np.unique(one).size > EMPTY, f"{name}: nothing is drawn of mode {mode}"
        found[mode] = other_pixels(one, two)
        if keep is not None and found[mode] > FEW:
            keep(f"{name}-{mode}", one, two)
    assert not browser.messages, browser.messages
    return found


def _kept(folder: Path) -> Callable[[str, Pixels, Pixels], None]:
    def keep(name: str, one: Pixels, two: Pixels) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        both = np.concatenate((one, two), axis=1).astype(np.uint8)
        Image.fromarray(both).save(folder / f"{name}.png")

    return keep


def main() -> int:
    """Compare; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="of shipped platforms; all of them"
    )
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="for pictures that differ")
    arguments = parser.parse_args()
    if CHROMIUM is None:
        print("pictures of pages cannot be compared without chromium")
        return UNABLE
    keep = None if arguments.keep is None else _kept(arguments.keep)
    platforms = modes = wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        browser = Browser(Path(folder) / "profile")
        try:
            for name in arguments.names or instance_files():
                found = compared(browser, name, Path(folder), keep=keep)
                if found is None:
                    print(f"{name}: has no live page")
                    continue
                platforms += 1
                modes += len(found)
                other = {mode: count for mode, count in found.items() if count > FEW}
                wrong += len(other)
                if other:
                    print(f"{name}: pictures differ in modes {', '.join(map(str, other))}")
        finally:
            browser.close()
    if wrong:
        print(f"{wrong} of {modes} modes of {platforms} platforms are drawn differently")
        return DIFFERENT
    print(f"confirmed: {modes} modes of {platforms} platforms are drawn alike on both pages")
    return CONFIRMED


if __name__ == "__main__":
    sys.exit(main())
