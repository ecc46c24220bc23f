"""Rebuild the kernel of live pages in data/live/ from native/ and viewer/module/.

    python -m viewer.kernel [--check] [--jobs N]

Emscripten compiles the sources of the wheel that follow paths of values, prove poses and step as a
controller does, and what calls them, to one module of WebAssembly with vectors of two doubles. It
is kept compressed: pages have it in them.
"""

from __future__ import annotations

import gzip
import json
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from tools.recording import ROOT, UNABLE, parser, save, sha256

NATIVE, CALLED = ROOT / "native", ROOT / "viewer" / "module"
TARGET = ROOT / "data" / "live"
KEPT = TARGET / "kernel.wasm.gz"
COMMAND = "python -m viewer.kernel"
COMPILER = "em++"
#: As CMakeLists.txt has them, without vectors of a processor.
OPTIONS = [
    *("-std=c++20", "-O3", "-msimd128", "-fno-exceptions", "-fno-rtti", "-fno-math-errno"),
    *("-Wno-psabi", "-DGSP_LANES=2"),
]
LINKED = [
    *("-O3", "-msimd128", "--no-entry"),
    *(part for x in ("STANDALONE_WASM", "ALLOW_MEMORY_GROWTH") for part in ("-s", f"{x}=1")),
]
_FUSED, _EXACT = "-ffp-contract=fast", "-ffp-contract=off"
#: What is compiled of native/: the source, and its options.
PARTS: list[tuple[str, list[str]]] = [
    (
        "reduced_homotopy",
        [_FUSED, "-DGSP_TRACK_VALUES=track_values_portable", "-DGSP_VALUES_ALONE"],
    ),
    ("tracker", [_FUSED, "-DGSP_TRACK=track_portable"]),
    ("tracker", [_FUSED, "-DGSP_TRACK=track_portable_short", "-DGSP_ORDER=4"]),
    ("tracker", [_FUSED, "-DGSP_TRACK=track_portable_real", "-DGSP_ORDER=4", "-DGSP_REAL"]),
    ("ends", [_FUSED, "-DGSP_DECIDE=decide_portable", "-DGSP_FINE=fine_portable"]),
    ("fine_points", [_EXACT, "-DGSP_FINE=fine_portable", "-DGSP_PARTS=2"]),
    (
        "far_poses",
        [
            *(_FUSED, "-DGSP_DECIDE_FAR=decide_far_portable"),
            *("-DGSP_FOLLOW_FAR=follow_far_portable", "-DGSP_FINE_FAR=fine_far_portable"),
        ],
    ),
    ("fine_far_poses", [_EXACT, "-DGSP_FINE_FAR=fine_far_portable", "-DGSP_PARTS=2"]),
    ("homotopy", [_EXACT]),
    ("controller", [_EXACT]),
    ("open_equations", [_EXACT]),
]
_INCLUDED = re.compile(r'^#include "([^"]+)"', re.MULTILINE)


def sources() -> list[Path]:
    """Return all files that the module is made of, those that others include among them."""
    open_, found = (
        [NATIVE / f"{name}.cpp" for name, _ in PARTS] + sorted(CALLED.glob("*.cpp")),
        set(),
    )
    while open_:
        path = open_.pop().resolve()
        if path not in found:
            found.add(path)
            text = path.read_text(encoding="utf-8")
            open_ += [path.parent / name for name in _INCLUDED.findall(text)]
    return sorted(found)


def digest() -> str:
    """Return a hash of the sources and of how they are compiled."""
    texts = [f"{path.relative_to(ROOT)}\n{path.read_text(encoding='utf-8')}" for path in sources()]
    return sha256("\n".join([json.dumps([OPTIONS, LINKED, PARTS]), *texts]))


def module(jobs: int) -> bytes:
    """Return the module."""
    work = [(NATIVE / f"{name}.cpp", options) for name, options in PARTS]
    work += [(path, [_EXACT]) for path in sorted(CALLED.glob("*.cpp"))]
    with tempfile.TemporaryDirectory() as folder:
        objects = [Path(folder) / f"{k}.o" for k in range(len(work))]

        def compile_(k: int) -> None:
            source, options = work[k]
            _run([COMPILER, *OPTIONS, *options, "-c", str(source), "-o", str(objects[k])])

        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(compile_, range(len(work))))
        linked = Path(folder) / "live.wasm"
        _run([COMPILER, *LINKED, *map(str, objects), "-o", str(linked)])
        return linked.read_bytes()


def _run(command: list[str]) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True)


def compiler() -> str:
    """Return the version of the compiler."""
    run = subprocess.run([COMPILER, "--version"], check=True, capture_output=True, text=True)
    return re.sub(r".*?(\d+\.\d+\.\d+).*", r"Emscripten \1", run.stdout.splitlines()[0])


def kept() -> Any:
    """Return the manifest of the module that is kept."""
    return json.loads((TARGET / "manifest.json").read_text(encoding="utf-8"))


def compressed(content: bytes) -> bytes:
    """Return the module compressed: as it is kept if that is the same, since compressors differ."""
    before = KEPT.read_bytes() if KEPT.exists() else b""
    if before and gzip.decompress(before) == content:
        return before
    return gzip.compress(content, 9, mtime=0)


def manifest(content: bytes) -> str:
    """Return what the module was made of."""
    record = {
        "manifest": {
            "command": COMMAND,
            "compiler": compiler(),
            "sources": {"files": len(sources()), "sha256": digest()},
        },
        "module": {"bytes": len(content), "sha256": sha256(content)},
    }
    return json.dumps(record, indent=1) + "\n"


def main() -> int:
    """Write or compare the module; return the exit code."""
    options = parser(__doc__)
    options.add_argument("--jobs", type=int, default=2, metavar="N", help="compilers at once")
    arguments = options.parse_args()
    if shutil.which(COMPILER) is None:
        print("the kernel of live pages cannot be built without emscripten")
        return UNABLE
    try:
        content = module(arguments.jobs)
    except subprocess.CalledProcessError as error:
        print(f"the kernel of live pages cannot be built: {error}\n{error.stderr}")
        return UNABLE
    files: dict[Path, str | bytes] = {
        KEPT: compressed(content),
        TARGET / "manifest.json": manifest(content),
    }
    return save(files, check=arguments.check, confirmed="the kernel of live pages")


if __name__ == "__main__":
    sys.exit(main())
