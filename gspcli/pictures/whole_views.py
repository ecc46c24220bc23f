"""A platform and its assembly modes as the content of a file: a page, or a drawing."""

from __future__ import annotations

from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.motion.poses.chosen_mode import chosen_mode
from gspcli.pictures.line_drawings import drawing
from gspcli.pictures.live_numbers import live_numbers
from gspcli.pictures.live_page import live_page
from gspcli.pictures.page import page
from gspcli.pictures.projection import View
from gspcli.pictures.staging import scene_of
from gspcli.solver import SolveResult, solve
from gspcli.wording import listed, shown

_PAGE, _DRAWINGS = "html", ("svg", "png", "pdf")


def view(
    platform: Instance | SolveResult,
    fmt: str = _PAGE,
    *,
    mode: int | None = None,
    all_modes: bool = False,
    seen_from: tuple[float, float] | None = None,
    names: bool = True,
    live: bool = False,
) -> bytes:
    """Return the content of a file that shows a platform, as `gsp view` writes it.

    Parameters
    ----------
    platform
        It is solved, or what `gspcli.solve` has found.
    fmt
        ``html`` for the page, which has all modes; ``svg``, ``png`` or ``pdf`` for a drawing
        (needs matplotlib).
    mode
        The number of the real pose that is shown (first); home if None.
    all_modes
        Of a drawing, whether there is a panel for each mode.
    seen_from
        Azimuth and elevation, degrees.
    names
        Whether primitives and constraints are named in the picture.
    live
        Whether the page solves again when values or the pose are moved.

    Raises
    ------
    ArgumentError
        If there is no such format, or it is no page and is to be live.
    GspError
        If there is no such mode, or a page cannot solve this platform.
    """
    if fmt not in (_PAGE, *_DRAWINGS):
        message = f"found {shown(fmt)}, expected {listed((_PAGE, *_DRAWINGS))}"
        raise ArgumentError(message, "fmt")
    if live and fmt != _PAGE:
        message = f"found a {fmt} that is to be live, expected {_PAGE}"
        raise ArgumentError(message, "fmt")
    result = solve(platform) if isinstance(platform, Instance) else platform
    drawn, seen = result.drawn, None if seen_from is None else View(*seen_from)
    start = 0
    if mode is not None or result.home is not None:
        start = chosen_mode(mode, result.home, drawn.counts.real) - 1
    if live:
        return live_page(scene_of(result), live_numbers(result), start, seen, names=names).encode()
    if fmt == _PAGE:
        return page(scene_of(result), start, None, seen, names=names).encode()
    alone = not all_modes and drawn.counts.real > 0
    scene = scene_of(result, only=start if alone else None)
    return drawing(scene, fmt, range(len(scene.series[0])), seen, names=names)
