"""The command line as a process of its own: `gsp`, or `python -m gspcli`."""

import gc
import os
import sys

from gspcli.errors import INTERRUPTED

#: Start-up makes some hundred thousand objects and hardly any garbage.
_OBJECTS = 100_000
#: Matrices are small here, and threads for their products would only wait for each other.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def main() -> int:
    """Run `gsp` with the arguments of the process; return the exit code."""
    gc.set_threshold(_OBJECTS)
    for variable in _ONE_THREAD:
        os.environ.setdefault(variable, "1")
    # Start-up can be interrupted, too.
    try:
        from gspcli.cli.main import run
        from gspcli.cli.streams import open_streams

        open_streams()
        code = run()
    except KeyboardInterrupt:
        code = INTERRUPTED
    # The process ends: no need to search what it leaves for garbage.
    gc.freeze()
    return code


if __name__ == "__main__":
    sys.exit(main())
