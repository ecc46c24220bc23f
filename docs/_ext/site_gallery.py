"""The gallery of the site: a drawing of every shipped instance, and its live page."""

from __future__ import annotations

import contextlib
import html
import io
from pathlib import Path

from gspcli.cli.commands.example import short_name
from gspcli.cli.main import run
from gspcli.resources import data_directory, instance_files
from gspcli.spec import load

#: The folder of the site with the views.
VIEWS = "views"
_GROUPS = {"platforms": "Real platforms", "examples": "The paper's platforms and special positions"}
#: 0 is done; poses that are infinitely many are shown by a sample, missing ones not at all.
_SHOWN = (0, 3)
#: What is tried, by suffix: not every platform has a page that solves.
_WAYS: dict[str, tuple[tuple[str, ...], ...]] = {"svg": ((),), "html": (("--live",), ())}


def write(folder: Path) -> list[Path]:
    """Write the drawing and the page of every instance; return the files.

    Those that are younger than the instance and the page's program are kept.
    """
    (folder / VIEWS).mkdir(parents=True, exist_ok=True)
    programs = ("view/page.html", "view/live.html", "live/kernel.wasm.gz")
    program = max((data_directory() / name).stat().st_mtime for name in programs)
    files = []
    for name, source in instance_files().items():
        for suffix in _WAYS:
            path = folder / VIEWS / f"{name}.{suffix}"
            files.append(path)
            youngest = max(program, source.stat().st_mtime)
            if not path.exists() or path.stat().st_mtime <= youngest:
                _write(name, source, path)
    return files


def _write(name: str, source: Path, path: Path) -> None:
    """Write a drawing or page in the first way that there is."""
    for way in _WAYS[path.suffix[1:]]:
        with contextlib.redirect_stderr(io.StringIO()) as errors:
            code = run(["view", str(source), *way, "-o", str(path)])
        if code in _SHOWN and path.exists():
            return
    message = f"gsp view @{name} ended with {code}: {errors.getvalue()}"
    raise RuntimeError(message)


def grid() -> str:
    """Return the gallery as HTML within Markdown: by group, each drawing a link to its page."""
    text = ""
    for folder, title in _GROUPS.items():
        text += f'\n## {title}\n\n<div class="gallery">\n'
        for name, path in instance_files().items():
            if path.parent.name != folder:
                continue
            instance = load(path)
            label = html.escape(f"{instance.name}: {short_name(instance.type)}")
            text += (
                f'<a href="{VIEWS}/{name}.html"><img src="{VIEWS}/{name}.svg" loading="lazy" '
                f'alt="{label}"><b>@{name}</b> {label}</a>\n'
            )
        text += "</div>\n"
    return text
