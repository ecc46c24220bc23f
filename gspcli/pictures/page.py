"""The page that shows a scene: one file that needs nothing else, not even a network.

The page itself is data (`viewer/pages.py` makes it); here it gets the scene, and all numbers
a second time as text, for people who cannot see the picture and browsers that cannot draw it.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from gspcli import __version__
from gspcli.pictures.line_drawings import View
from gspcli.pictures.scene import Scene, SceneSeries
from gspcli.pictures.stage import first_mode, scene_of
from gspcli.resources import data_path

if TYPE_CHECKING:
    from gspcli.solver.result import SolveResult


#: Significant digits of the size of the scene in the list; the pose that is shown has more.
_DIGITS = 4
_BLANK = re.compile(r"@@(\w+)@@")


def page(
    scene: Scene,
    start: int = 0,
    series: int | None = None,
    view: View | None = None,
    *,
    names: bool = True,
) -> str:
    """Return the page of a scene, a whole HTML document.

    First it shows the assembly mode `start`, from 0, of a series (if None, of the first that has
    poses), from a view, with names of primitives and constraints.
    """
    if series is None:
        series = next((k for k, each in enumerate(scene.series) if len(each)), 0)
    seen = {"first": series, "start": 0 if series else start, "names": names}
    return filled("page.html", parts(scene, start, view, seen))


def parts(
    scene: Scene, start: int, view: View | None, seen: Mapping[str, object]
) -> dict[str, str]:
    """Return the texts about a scene in every page, by the marks in its template.

    `seen` says to the page's program how it is seen first.
    """
    modes = scene.series[0]
    eye = (view or View()).axes[2].round(6).tolist()
    return {
        "title": escape(scene.title),
        "type": escape(scene.type_id),
        "summary": escape(scene.summary),
        "picture": escape(_picture(scene)),
        "modes_heading": escape(f"{modes.title} ({len(modes)})"),
        "modes": _modes(scene, modes),
        "constraints": _constraints(scene, modes, start),
        "footer": escape(
            f"gsp {__version__}. Lengths in {scene.length_unit}, x y z as in the file."
        ),
        "scene": data({**scene.to_json(), **seen, "eye": eye}),
    }


def data(content: Mapping[str, object]) -> str:
    """Return plain data as the content of a script element."""
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"))
    # The element ends at the first "</", wherever it stands.
    return text.replace("</", "<\\/")


def filled(template: str, said: Mapping[str, str]) -> str:
    """Return a page of ``data/view`` with everything said that it has marks for."""
    text = data_path("view", template).read_text(encoding="utf-8")
    return _BLANK.sub(lambda match: said[match[1]], text)


def number(value: float, size: float = 1.0) -> str:
    """Return a number as people read it; rounding errors beside `size` are zero."""
    text = f"{0.0 if abs(value) < 1e-12 * size else value:.6g}"
    return text.replace("-", "−")


def fixed(value: float, places: int) -> str:
    """Return a number with this many decimals; zero has no sign."""
    return f"{round(value, places) + 0.0:.{places}f}".replace("-", "−")


def condition(value: float) -> str:
    """Return a condition number: three digits, whole if it is larger."""
    if not math.isfinite(value):
        return "∞"
    return f"{value:.3g}" if value < 1000 or value >= 1e6 else f"{value:.0f}"


def _picture(scene: Scene) -> str:
    """Return what the picture shows, in words."""
    bonds = ", ".join(f"{b.kind.name} {b.platform_name}–{b.base_name}" for b in scene.bonds)
    return (
        f"Base and platform of {scene.title} joined by six constraints: {bonds}. "
        "All numbers are in the tables."
    )


def _modes(scene: Scene, modes: SceneSeries) -> str:
    if not len(modes):
        which = "isolated real" if len(scene.series) > 1 else "real"
        return f"<p>There is no {which} pose.</p>"
    places = max(0, _DIGITS - math.ceil(math.log10(scene.size)))
    shown = {name: x for name, x in modes.facts.items() if name in _COLUMNS and len({*x}) > 1}
    rows = "".join(
        f'<tr><td><button type="button" aria-label="show mode {k + 1}">{k + 1}</button></td>'
        + "".join(f"<td>{fixed(x, places)}</td>" for x in modes.T[k].tolist())
        + f'<td><i class="chip"></i>{condition(modes.conditions[k])}</td>'
        + "".join(f"<td>{escape(str(values[k]))}</td>" for values in shown.values())
        + "</tr>"
        for k in range(len(modes))
    )
    heads = ["no.", "x", "y", "z", "condition", *shown]
    return _table("modes", heads, rows)


#: Facts that have a column in the list; all of them are shown for the chosen pose.
_COLUMNS = ("sides", "multiplicity")


def _constraints(scene: Scene, modes: SceneSeries, start: int) -> str:
    rows = "".join(
        f"<tr><td>{bond.number}</td>"
        f'<td class="text">{escape(bond.platform_name)} – {escape(bond.base_name)} '
        f'<span class="kind">{bond.kind.name}</span></td>'
        f"<td>{number(bond.value)} {escape(scene.unit(bond))}</td>"
        f'<td class="measured">{number(modes.measured[start, k]) if len(modes) else ""}</td></tr>'
        for k, bond in enumerate(scene.bonds)
    )
    return _table("constraints", ["no.", "between", "asked for", "measured"], rows)


def _table(name: str, heads: list[str], rows: str) -> str:
    head = "".join(
        f'<th scope="col"{" class=text" if text == "between" else ""}>{escape(text)}</th>'
        for text in heads
    )
    return (
        f'<div class="scroll" tabindex="0"><table id="{name}"><thead><tr>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


_HEIGHT = 620


def notebook_view(result: SolveResult) -> str:
    """Return a result as HTML for a notebook: its page in a frame of its own."""
    document = escape(page(scene_of(result), first_mode(result.drawn)))
    title = escape(result.instance.name or result.instance.type.id)
    # In a frame of its own the page's style and scripts touch nothing of the notebook's.
    return (
        f'<iframe srcdoc="{document}" title="{title}" sandbox="allow-scripts allow-downloads" '
        f'style="width: 100%; height: {_HEIGHT}px; border: 1px solid #8884; border-radius: 6px">'
        "</iframe>"
    )
