"""Check an installed wheel: the kernel has the stable ABI where it can, and the data are with it.

    python tools/wheel.py

Run by the Python into whose environment the wheel was installed, outside the checkout.
"""

from __future__ import annotations

import sys
import sysconfig
from pathlib import Path

import gspcli
from gspcli import _kernel
from gspcli.resources import data_directory, instance_files

#: The first version whose stable ABI has what nanobind needs.
STABLE_SINCE = (3, 12)


def main() -> int:
    """Print what is installed; return the exit code."""
    home = Path(gspcli.__file__).parent
    kernel = Path(str(_kernel.__file__)).name
    stable = not kernel.endswith(str(sysconfig.get_config_var("EXT_SUFFIX")))
    faults = []
    if data_directory().parent != home:
        faults.append(f"the data are in {data_directory()}, not in the package")
    if stable != (sys.version_info >= STABLE_SINCE):
        faults.append(f"the kernel is {kernel} for Python {sys.version.split()[0]}")
    print(f"gspcli {gspcli.__version__}: {kernel}, {len(instance_files())} instance files")
    print(*faults, sep="\n", end="\n" if faults else "")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
