"""Run the commands of the pages as on other processors: what people read must not depend on them.

    python -m tools.verify.machines [--fast]

These commands are run: those that a page or a help shows, except those that take long, and those
from which the reference of output is made. Each is run with three sets of instructions: of the
kernel (``GSP_BUILD``), of OpenBLAS (``OPENBLAS_CORETYPE``) and of NumPy. Tables and sentences must
be the same, byte for byte. In JSON and CSV so must be condition numbers and residuals; other
numbers are doubles with all their digits, and agree to 1e-9. Numbers of steps (`EFFORT`) may
differ. ``--fast`` runs some pages and commands only.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

from tools.recording import ROOT, UNABLE, report

#: Environment variables by machine, the oldest first.
MACHINES = {
    "portable": {
        "GSP_BUILD": "portable",
        "OPENBLAS_CORETYPE": "Prescott",
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    },
    "avx2": {
        "GSP_BUILD": "avx2",
        "OPENBLAS_CORETYPE": "Haswell",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    },
    "avx512": {"GSP_BUILD": "avx512", "OPENBLAS_CORETYPE": "SkylakeX"},
}
#: Pages that are run with --fast: modes of vibration, conditions, forces, clearances, equal loads.
FAST = (
    "README.md",
    "analyze.md",
    "analyze.md",
    "singularities.md",
    "dynamics.md",
    "track.md",
    "machine-file.md",
    "measure.md",
    "track.md",
    "track.md",
    "pose-singularities.md",
    "track.md",
    "singularities.md",
    "track.md",
    "workspace.md",
)
#: Commands whose runs for the reference are, too: motions, multiple poses, tracks, requirements.
FAST_COMMANDS = ("solve", "measure", "track", "dynamics")
#: Keys whose numbers are written with no more digits than are known.
ROUNDED = ("condition", "residual")
#: Keys that count steps, which another processor may take otherwise.
EFFORT = ("parts",)
#: Other numbers of JSON and CSV agree to this part of the largest in their row or column.
_AGREE = 1e-9
_NO_COLUMNS: Mapping[str, float] = MappingProxyType({})

#: What a page shows, as data in one line of it.
_SCENE = re.compile(r'(<script type="application/json" id="\w+">)(.*)</script>')
#: This much of a line is named before a difference, and after it.
_SHOWN = 60

Outputs = dict[str, str]


def outputs(*, fast: bool) -> Iterator[tuple[str, str]]:
    """Yield what is run, and what it prints, on this machine."""
    from tools.build import samples, shown_commands, shown_output

    groups = {page.name: shown_commands.shown_in(page) for page in shown_commands.pages()}
    if fast:
        groups = {name: groups[name] for name in FAST}
    else:
        groups |= {f"gsp {name} --help": shown for name, shown in shown_commands.helps().items()}
    for name, group in groups.items():
        chosen = [one for one in group if shown_commands.is_short(one) and not one.missing]
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            for one, done in zip(chosen, shown_output.run_in_order(chosen), strict=True):
                yield f"{name}: {one.line}", done.output
    with tempfile.TemporaryDirectory() as folder:
        for name, command in samples.described().items():
            if "json" not in samples.choices(command, "format"):
                continue
            if fast and name not in FAST_COMMANDS:
                continue
            for sample in samples.samples(name, command):
                line = [*samples.words(name, sample, Path(folder)), "--format", "json"]
                yield f"gsp {' '.join(line)}".replace(folder, "."), samples.output(line)


def differences(first: str, second: str) -> list[str]:
    """Return the differences of two outputs of one command, which should be equal."""
    if first == second:
        return []
    for parsed in (_json, _csv):
        one, other = parsed(first), parsed(second)
        if one is not None and other is not None:
            return list(_apart(one, other, "", 0.0))
    lines = first.splitlines(), second.splitlines()
    if len(lines[0]) != len(lines[1]):
        return ["another number of lines"]
    return [remark for a, b in zip(*lines, strict=True) if a != b for remark in _of_line(a, b)]


def _of_line(one: str, other: str) -> list[str]:
    """Return how two lines differ; in a page the data of a scene are compared as JSON."""
    parts, others = _SCENE.fullmatch(one), _SCENE.fullmatch(other)
    if parts and others and parts[1] == others[1]:
        return differences(parts[2], others[2])
    k = next((k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), 0)
    near = slice(max(0, k - _SHOWN), k + _SHOWN)
    return [f"{one[near]!r} is not {other[near]!r}"]


def _json(text: str) -> object | None:
    try:
        found: object = json.loads(text)
        return found
    except ValueError:
        return None


def _csv(text: str) -> object | None:
    rows = list(csv.reader(io.StringIO(text)))
    if len(rows) < 2 or len(rows[0]) < 2 or len({len(row) for row in rows}) > 1:
        return None
    return [dict(zip(rows[0], map(_number, row), strict=True)) for row in rows[1:]]


def _number(text: str) -> object:
    try:
        return float(text)
    except ValueError:
        return text


def _apart(
    one: object, other: object, key: str, size: float, columns: Mapping[str, float] = _NO_COLUMNS
) -> Iterator[str]:
    if key in EFFORT:
        return
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        size = _largest(one.values(), size)
        for name, value in one.items():
            yield from _apart(value, other[name], name, max(size, columns.get(name, 0.0)))
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        size, columns = _largest(one, size), _columns(one)
        for value, same in zip(one, other, strict=True):
            yield from _apart(value, same, key, size, columns)
    elif isinstance(one, float) and isinstance(other, float) and key not in ROUNDED:
        if not abs(one - other) <= _AGREE * max(abs(one), size) and str(one) != str(other):
            yield f"{key}: {one} is not {other}"
    elif one != other and str(one) != str(other):
        yield f"{key}: {one} is not {other}"


def _columns(rows: list[object]) -> dict[str, float]:
    """Return the largest modulus of each key in a list of rows."""
    found: dict[str, float] = {}
    for row in rows:
        for key, value in row.items() if isinstance(row, dict) else ():
            if isinstance(value, float):
                found[key] = max(abs(value), found.get(key, 0.0))
    return found


def _largest(values: Iterable[object], size: float) -> float:
    numbers = [abs(x) for x in values if isinstance(x, float)]
    return max(numbers, default=size)


def _of(machine: str, *, fast: bool) -> Outputs | None:
    """Return what a machine prints; None if this processor lacks its instructions."""
    words = [sys.executable, "-m", "tools.verify.machines", "--print", *(["--fast"] * fast)]
    done = subprocess.run(
        words,
        cwd=ROOT,
        env={**os.environ, **MACHINES[machine]},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode == UNABLE:
        return None
    if done.returncode:
        raise SystemExit(done.stderr)
    printed: Outputs = json.loads(done.stdout)
    return printed


def main() -> int:
    """Compare what the machines print; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--fast", action="store_true", help="some pages and commands only")
    parser.add_argument("--print", action="store_true", help="what this machine prints, as JSON")
    arguments = parser.parse_args()
    if arguments.print:
        from gspcli import _kernel

        try:
            _kernel.build()
        except ValueError:
            return UNABLE
        print(json.dumps(dict(outputs(fast=arguments.fast))))
        return 0
    found = {name: _of(name, fast=arguments.fast) for name in MACHINES}
    able = {name: printed for name, printed in found.items() if printed is not None}
    first, *others = able
    remarks = [
        f"{line}: {first} and {other}: {remark}"
        for other in others
        for line, text in able[first].items()
        for remark in differences(text, able[other][line])
    ]
    return report(remarks, f"{len(able[first])} commands print the same on {', '.join(able)}")


if __name__ == "__main__":
    sys.exit(main())
