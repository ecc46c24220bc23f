"""Compile the LaTeX that every command writes.

    python -m tools.verify.latex --check

Needs pdflatex with booktabs and amsmath (on Debian: texlive-latex-base, texlive-latex-recommended);
ends with 4 without it, and with 1 if anything does not compile.
"""

from __future__ import annotations

import contextlib
import io
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from gspcli.catalogue.kinds import KINDS
from gspcli.cli.main import run
from gspcli.resources import data_directory
from tools.recording import CONFIRMED, DIFFERENT, UNABLE, parser

_LOOP = data_directory() / "trajectories" / "mode-change"
#: A call of every command that writes LaTeX; `tests/cli/test_latex.py` sees to that.
CALLS = (
    "enumerate --limit 40",
    "enumerate --count",
    "enumerate --coincident --only PP",
    "enumerate --coincident 6PP --limit 9",
    "show DPL DPL DLP ALL ALH AHH",
    "bound 421",
    "bound 1 17 3850",
    "constraint",
    *(f"constraint {kind.name}" for kind in KINDS),
    "realize DPL DPL DLP ALL ALH AHH",
    "realize 6-3",
    "table all",
    "table errata",
    "derive AAA",
    "derive PSC",
    "derive PSC --expand",
    "derive 6.2",
    "derive 6.8",
    "atlas summary",
    "example",
    "check @dietmaier @example-6.8",
    "count @planar-hexagons",
    "solve @example-6.8",
    "solve @dietmaier --all --digits 20",
    "solve @no-real-pose --legend",
    "sample 3D3A PH PH PH --count 20 --jobs 1",
    "clearance @octahedral-3-3 --mode 1",
    "scan @octahedral-3-3 --vary 1=1.4:1.6:3 --vary 2=1:2:2",
    "scan @octahedral-3-3 --vary 1=1:2:5 --folds",
    f"track {_LOOP}.yaml {_LOOP}.csv --allow-loss --clearance",
    "measure @dietmaier --pose 0.1,0.2,1.5,1,0.1,0,0",
    "workspace @workspace-study",
    "workspace @workspace-study --over x,z",
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


def written(call: str) -> str:
    """Return what a command writes as LaTeX."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(io.StringIO()):
        run([*call.split(), "--format", "latex"])
    return printed.getvalue()


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
    wrong = 0
    for call in CALLS:
        found = complaint(written(call))
        if found is not None:
            wrong += 1
            print(f"gsp {call}: {found}", file=sys.stderr)
    print(f"{len(CALLS) - wrong} of {len(CALLS)} compile")
    return DIFFERENT if wrong else CONFIRMED


if __name__ == "__main__":
    sys.exit(main())
