"""Rebuild the pictures of terminal output in docs/images/.

    python -m tools.build.pictures [--check]

Every command below runs in a pseudo-terminal and what it prints becomes an SVG. Residuals, which
are rounding errors, may differ from the recorded ones.
"""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

from rich.console import Console
from rich.text import Text

from tools.recording import ROOT, parser, report, save

WIDTH = 100
IMAGES = ROOT / "docs" / "images"
PICTURES = {
    "bound": ["bound", "3D3A", "PL", "PL", "LP"],
    "solve": ["solve", "data/examples/octahedral-3-3.yaml"],
    "enumerate": ["enumerate", "--by-class"],
}

#: The largest residual, 0 or about 1e-15.
RESIDUAL = re.compile(r"(?<=residuals&#160;at&#160;most&#160;)[\d.]+e[+-]\d\d")

# rich's own template loads fonts from the network.
FORMAT = """\
<svg class="rich-terminal" viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg">
<style>
.{unique_id}-matrix {{
  font-family: ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace;
  font-size: {char_height}px; line-height: {line_height}px;
}}
{styles}
</style>
<defs>
<clipPath id="{unique_id}-clip-terminal">
<rect x="0" y="0" width="{terminal_width}" height="{terminal_height}" />
</clipPath>
{lines}
</defs>
{chrome}
<g transform="translate({terminal_x}, {terminal_y})" clip-path="url(#{unique_id}-clip-terminal)">
{backgrounds}
<g class="{unique_id}-matrix">
{matrix}
</g>
</g>
</svg>
"""


def terminal_output(arguments: list[str]) -> str:
    """Return what `gsp` prints on a terminal, with its colours."""
    leader, follower = pty.openpty()
    environment = {**os.environ, "COLUMNS": str(WIDTH), "TERM": "xterm-256color"}
    environment.pop("NO_COLOR", None)
    with subprocess.Popen(
        [sys.executable, "-m", "gspcli", *arguments],
        stdout=follower,
        stderr=subprocess.DEVNULL,
        env=environment,
    ) as process:
        os.close(follower)
        chunks = []
        while True:
            try:
                chunk = os.read(leader, 65536)
            except OSError:  # how Linux reports that the other end is closed
                break
            if not chunk:
                break
            chunks.append(chunk)
    if process.returncode:
        sys.exit(f"gsp {' '.join(arguments)} ended with {process.returncode}")
    return b"".join(chunks).decode().replace("\r\n", "\n")


def picture(name: str, arguments: list[str]) -> str:
    """Return the picture of a command."""
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        console = Console(record=True, width=WIDTH, file=nowhere)
        console.print(Text(f"$ gsp {' '.join(arguments)}", style="bold green"))
        console.print(Text.from_ansi(terminal_output(arguments).rstrip()))
        return console.export_svg(
            title="gsp", code_format=FORMAT, unique_id=name, font_aspect_ratio=0.61
        )


def without_residual(svg: str) -> str:
    """Return a picture without the largest residual."""
    return RESIDUAL.sub("", svg)


def main() -> int:
    """Write or compare every picture; return the exit code."""
    arguments = parser(__doc__).parse_args()
    pictures = {IMAGES / f"{name}.svg": picture(name, words) for name, words in PICTURES.items()}
    if not arguments.check:
        return save(pictures, check=False, confirmed="")
    different = [
        f"docs/images/{path.name}: differs"
        for path, svg in pictures.items()
        if not path.is_file()
        or without_residual(path.read_text(encoding="utf-8")) != without_residual(svg)
    ]
    return report(different, f"pictures of {len(pictures)} commands")


if __name__ == "__main__":
    sys.exit(main())
