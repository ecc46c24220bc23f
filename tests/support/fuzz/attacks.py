"""What the attacks on `gsp track` share: commands within the process, and attacks by seeds."""

from __future__ import annotations

import contextlib
import io

from gspcli.cli.main import run


def call(*words: str) -> tuple[int, str, str]:
    """Run a command; return the exit code, what is written and what is said."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run(list(words))
    return code, out.getvalue(), err.getvalue()
