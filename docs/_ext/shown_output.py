"""Renew the output that the pages show under commands.

    python -m docs._ext.shown_output [--check]

What stands under a command in a block of ``console`` is replaced by what the command prints today,
results before errors; a command under which nothing stands only leaves its files to the others.
"""

from __future__ import annotations

import contextlib
import sys
import tempfile
from pathlib import Path

from docs._ext.shown_commands import Done, Shown, pages, run_line, shown_in
from docs._ext.stand_ins import prepare
from tools.recording import ROOT, parser, save


def run_in_order(commands: list[Shown]) -> list[Done]:
    """Run the command lines of a page in the current folder, one after the other."""
    done, kept = [], set[str]()
    for shown in commands:
        prepare(shown, kept)
        before = _written()
        done.append(run_line(shown.line))
        kept |= {name for name, time in _written().items() if before.get(name) != time}
    return done


def same(found: str, shown: str) -> bool:
    """Return whether two outputs agree but for blanks at the ends of lines."""
    return _comparable(found) == _comparable(shown)


def renewed(page: Path) -> str:
    """Return a page with today's output of its commands."""
    text = page.read_text(encoding="utf-8")
    blocks = [shown for shown in shown_in(page) if f"\n$ {shown.line}\n" in text]
    if not any(shown.output for shown in blocks):
        return text
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        results = run_in_order(blocks)
    for shown, done in zip(blocks, results, strict=True):
        if shown.output and not same(done.output, shown.output):
            lines = "".join(f"{line.rstrip()}\n" for line in done.output.splitlines())
            old = f"$ {shown.line}\n{shown.output}"
            assert old in text, shown.line
            text = text.replace(old, f"$ {shown.line}\n{lines}", 1)
    return text


def _comparable(output: str) -> list[str]:
    return [line.rstrip() for line in output.strip().splitlines()]


def _written() -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in Path().iterdir()}


def main() -> int:
    """Write or compare the pages; return the exit code."""
    arguments = parser(__doc__).parse_args()
    texts = {page: renewed(page) for page in pages()}
    changed = {page: text for page, text in texts.items() if text != page.read_text("utf-8")}
    for page in changed:
        print(page.relative_to(ROOT).as_posix())
    return save(changed, check=arguments.check, confirmed="output that the pages show")


if __name__ == "__main__":
    sys.exit(main())
