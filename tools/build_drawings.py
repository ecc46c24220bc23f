"""Rebuild the drawings of platforms and of joint chains in docs/images/.

    python tools/build_drawings.py [--check]

What `gsp view -o FILE.svg` and `gsp realize -o FILE.svg` draw. Another version of matplotlib may
write other bytes for the same drawing.
"""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
from pathlib import Path

from recording import ROOT, parser, save

sys.path.insert(0, str(ROOT))

from gspcli.cli.main import run

IMAGES = ROOT / "docs" / "images"
DRAWINGS = {"example-6.8": ["view", "@example-6.8", "--mode", "57"]}


def drawn(words: list[str]) -> bytes:
    """Return what a command draws."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drawing.svg"
        with contextlib.redirect_stderr(io.StringIO()):
            code = run([*words, "-o", str(path)])
        if code:
            sys.exit(f"gsp {' '.join(words)} ended with {code}")
        return path.read_bytes()


def main() -> int:
    """Write or compare every drawing; return the exit code."""
    arguments = parser(__doc__).parse_args()
    files: dict[Path, str | bytes] = {
        IMAGES / f"{name}.svg": drawn(words) for name, words in DRAWINGS.items()
    }
    return save(files, check=arguments.check, confirmed=f"{len(files)} drawings")


if __name__ == "__main__":
    sys.exit(main())
