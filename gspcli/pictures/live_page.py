"""The page that solves a platform again while one moves its values or its pose.

One file, like the page of `gspcli.pictures.page`, with the kernel in WebAssembly in it and the
numbers from which it solves (`gspcli.pictures.live_numbers`).
"""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.pictures.live_numbers import live_module
from gspcli.pictures.page import data, filled, parts
from gspcli.pictures.projection import View
from gspcli.pictures.scene import Scene


def live_page(
    scene: Scene,
    live: Mapping[str, Any],
    start: int = 0,
    view: View | None = None,
    *,
    names: bool = True,
    frame: PoseFrame = IDENTITY,
) -> str:
    """Return the live page of a scene, a whole HTML document.

    Parameters
    ----------
    scene
        What to show; its first series are the assembly modes, numbered so.
    live
        What the page solves from, as `gspcli.pictures.live_numbers.live_numbers` returns it.
    start
        The assembly mode that is followed first, from 0.
    view
        From where it is seen first; a usual one if None.
    names
        Whether primitives and constraints are named at first.
    frame
        The frame in which sliders of the pose express it.
    """
    said = parts(scene, start, view, {"start": start, "names": names})
    if live["reservation"]:
        said["footer"] += escape(f" That no pose is missing is {live['reservation']}.")
    content = data({**live, "frame": _expressed(frame)})
    return filled("live.html", {**said, "live": content, "module": live_module()})


def _expressed(frame: PoseFrame) -> dict[str, Any]:
    """Return how sliders express poses: frames in both bodies, by rows, and the text about them."""
    what = frame.words or "poses of the platform in the base"
    return {
        **{
            body: {"R": one.matrix.ravel().tolist(), "T": one.origin.tolist()}
            for body, one in (("base", frame.of_base), ("platform", frame.of_platform))
        },
        "words": f"{what}; turns about its fixed axes x, y, z, one after the other (--euler xyz)",
    }
