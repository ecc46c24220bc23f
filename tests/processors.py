"""Run the suite as on other processors: kernels of BLAS, instruction sets of the kernel and NumPy.

    python -m tests.processors [OPTION OF PYTEST ...]
    python -m tests.processors --pick HASH

The first runs the whole suite on each of `PROCESSORS`, one after the other, and ends with 1 if it
fails on one. The second prints what the shell sets for the one that a hash picks. Processors whose
instructions this one lacks are left out, and named.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]


class Processor(NamedTuple):
    """A kernel of OpenBLAS, and a set of instructions of ours."""

    blas: str
    instructions: str

    def __str__(self) -> str:
        """Return its name."""
        return f"{self.blas} ({self.instructions})"


PROCESSORS = (
    Processor("Prescott", "portable"),
    Processor("Haswell", "avx2"),
    Processor("Zen", "avx2"),
    Processor("SkylakeX", "avx512"),
)
#: Parts of the names of features of NumPy that a processor without those instructions lacks.
_BEYOND = {"portable": ("",), "avx2": ("AVX512", "V4"), "avx512": ()}


def environment(processor: Processor) -> dict[str, str]:
    """Return the variables of a processor."""
    from numpy._core._multiarray_umath import __cpu_dispatch__ as features

    beyond = _BEYOND[processor.instructions]
    lacking = [name for name in features if any(part in name for part in beyond)]
    found = {"GSP_BUILD": processor.instructions, "OPENBLAS_CORETYPE": processor.blas}
    return found | ({"NPY_DISABLE_CPU_FEATURES": " ".join(lacking)} if lacking else {})


def able() -> list[Processor]:
    """Return the processors whose instructions this one has; name the others."""
    code = "from gspcli import _kernel; _kernel.build()"
    found = []
    for processor in PROCESSORS:
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=ROOT,
            env={**os.environ, "GSP_BUILD": processor.instructions},
            capture_output=True,
            check=False,
        )
        if done.returncode == 0:
            found.append(processor)
        else:
            print(f"left out: {processor}: this processor cannot run it", file=sys.stderr)
    return found


def main() -> int:
    """Run the suite; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pick", metavar="HASH", help="print the variables of one of them")
    arguments, options = parser.parse_known_args()
    chosen = able()
    if arguments.pick:
        picked = chosen[int(arguments.pick, 16) % len(chosen)]
        print(f"the suite runs as on {picked}", file=sys.stderr)
        for name, value in environment(picked).items():
            print(f"export {name}={shlex.quote(value)}")
        return 0
    command = [sys.executable, "-m", "pytest", "-q", "-n", "auto", "-m", "not slow", *options]
    failed = []
    for processor in chosen:
        print(f"== {processor}", flush=True)
        done = subprocess.run(
            command, cwd=ROOT, env={**os.environ, **environment(processor)}, check=False
        )
        failed += [str(processor)] if done.returncode else []
    print(f"failed: {', '.join(failed)}" if failed else "passed on all")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
