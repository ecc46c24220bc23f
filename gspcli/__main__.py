"""Run the command line as `python -m gspcli`."""

import sys

from gspcli.cli.main import run

if __name__ == "__main__":
    sys.exit(run())
