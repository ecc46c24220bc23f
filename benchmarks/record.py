"""Record what the peers answer, for the tests.

    python -m benchmarks.record tests/oracles/authorities

Each case gets an archive with its instance file and the raw outputs.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from benchmarks import macaulay2, msolve, phc
from benchmarks.cases import CASES
from benchmarks.homotopy import Homotopy
from gspcli.spec import dumps

SEED = 1
RECORDED = ("6-6", "Dietmaier", "3PH+3HP", "3D3A PL PL LP")
#: The names in the archives, by the names that the peers' modules give.
FILES = {
    "system": "phc.txt",
    "track.out": "macaulay2.txt",
    "result.ms": "msolve.txt",
    "log.ms": "msolve-log.txt",
}


def main(target: Path) -> None:
    """Ask the peers and keep their answers."""
    for case in CASES:
        if case.key not in RECORDED:
            continue
        [instance] = case.draw(SEED, 1)
        archive = target / f"{case.key.replace(' ', '-').lower()}.zip"
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            answers = [
                phc.blackbox(instance, folder, 600, split=case.split),
                macaulay2.track(Homotopy.of(instance, SEED), folder, 600),
                msolve.isolate(msolve.executable(), instance, folder, 600),
            ]
            for answer in answers:
                if answer.trouble:
                    message = f"{case.key}: {answer.trouble}"
                    raise SystemExit(message)
            texts = {kept: (folder / source).read_text() for source, kept in FILES.items()}
            with ZipFile(archive, "w", ZIP_DEFLATED) as written:
                for kept, text in ({"instance.yaml": dumps(instance)} | texts).items():
                    written.writestr(ZipInfo(kept), text, ZIP_DEFLATED)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
