"""Compile the LaTeX that every command writes.

    python -m tools.verify.latex --check

Needs pdflatex with booktabs and amsmath (on Debian: texlive-latex-base, texlive-latex-recommended);
ends with 4 without it, and with 1 if anything does not compile.
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from gspcli.catalogue.kinds import KINDS
from tools.build.samples import choices, described, output, samples, words
from tools.recording import UNABLE, parser, report

#: Calls besides the samples of the commands.
MORE = (
    "enumerate --first 40",
    "enumerate --by-class",
    "enumerate --coincident --only PP",
    *(f"constraint {kind.name}" for kind in KINDS),
    "table all",
    "derive AAA",
    "derive PSC --expand",
    "derive 6.2",
    "derive 6.8",
    "solve @no-real-pose --legend",
    "scan @octahedral-3-3 --vary 1=1.4:1.6:3 --vary 2=1:2:2",
    "analyze @octahedral-3-3 --mode 1 --load 0,0,-9.81 --tolerance 0.001",
)
_DOCUMENT = r"""\documentclass{article}
\usepackage[a0paper,landscape,margin=1cm]{geometry}
\usepackage[utf8]{inputenc}
\usepackage{amsmath,booktabs}
\allowdisplaybreaks
\begin{document}
%s
\end{document}
"""


def calls(folder: Path) -> Iterator[list[str]]:
    """Yield calls of every command that writes LaTeX; files that they read are in a folder."""
    for name, command in described().items():
        if "latex" in choices(command, "format"):
            yield from (words(name, sample, folder) for sample in samples(name, command))
    yield from map(shlex.split, MORE)


def written(call: Sequence[str]) -> str:
    """Return what a command writes as LaTeX."""
    return output([*call, "--format", "latex"])


def complaint(text: str) -> str | None:
    """Return the first thing that LaTeX finds wrong with a text; None if it compiles."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "page.tex").write_text(_DOCUMENT % text, encoding="utf-8")
        done = subprocess.run(
            ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"],
            cwd=folder,
            capture_output=True,
            check=False,
        )
    if done.returncode == 0:
        return None
    lines = done.stdout.decode("utf-8", "replace").splitlines()
    first = next((k for k, line in enumerate(lines) if line.startswith("!")), 0)
    return " ".join(lines[first : first + 4])


def main() -> int:
    """Compile everything; return the exit code."""
    parser(__doc__).parse_args()
    if shutil.which("pdflatex") is None:
        print("pdflatex is missing: nothing could be compiled", file=sys.stderr)
        return UNABLE
    with tempfile.TemporaryDirectory() as folder:
        found = {shlex.join(call): complaint(written(call)) for call in calls(Path(folder))}
    wrong = [f"gsp {call}: {said}" for call, said in found.items() if said is not None]
    return report(wrong, f"LaTeX of {len(found)} calls compiles")


if __name__ == "__main__":
    sys.exit(main())
