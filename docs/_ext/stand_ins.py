"""Files that stand for the reader's where a command is shown: ``platform.yaml`` and so on.

A page may have the file itself, as the first block of yaml or csv; else it is made here.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import yaml

from docs._ext.shown_commands import Shown, run_line
from gspcli.resources import data_path, instance_files
from tools.recording import ROOT

#: A hexapod about six units large, with ranges, cones and an unturned pose 5 above the base.
_JOINTS = (
    (4, 1, 2.5, 1.5),
    (1, 4, 1.5, 2.5),
    (-3, 3, -2, 2.5),
    (-4.5, 1, -3, 0.5),
    (-2.5, -4, -1, -2.5),
    (2.5, -3.5, 2, -2),
)
#: What stands for ``platform.yaml``, by command: a shipped machine, else the hexapod above.
_MACHINES = {
    "calibrate": "workspace-study-cones",
    "certify": "figure-3",
    "export": "nano-hexapod",
    "maximize-real": "figure-3",
    "path": "workspace-study",
    "realize": "figure-4",
    "sensors": "workspace-study",
    "workspace": "workspace-study-cones",
}
#: Where a page or help means a machine of its own.
_OF_PLACE = {
    "gsp solve --help": "figure-4",
    "gsp dynamics --help": "MASSES",
    "docs/solve.md": "figure-4",
}
_DYNAMICS = ROOT / "docs" / "dynamics.md"
#: Which block of which page a file is.
_BLOCKS = {
    ("docs/dynamics.md", "hexapod.yaml"): (_DYNAMICS, "yaml", 0),
    ("docs/dynamics.md", "rotary.yaml"): (_DYNAMICS, "yaml", 1),
    ("gsp dynamics --help", "rotary.yaml"): (_DYNAMICS, "yaml", 1),
    ("docs/dynamics.md", "path.csv"): (_DYNAMICS, "csv", 0),
    ("gsp dynamics --help", "path.csv"): (_DYNAMICS, "csv", 0),
    ("docs/import.md", "robot.xml"): (ROOT / "docs" / "import.md", "xml", 0),
    ("docs/import.md", "joints.csv"): (ROOT / "docs" / "import.md", "csv", 0),
    ("gsp import --help", "joints.csv"): (ROOT / "docs" / "import.md", "csv", 0),
    ("gsp import --help", "robot.xml"): (ROOT / "docs" / "import.md", "xml", 0),
    ("docs/tutorial-rotary.md", "moves.csv"): (ROOT / "docs" / "tutorial-rotary.md", "csv", 0),
    ("docs/track.md", "moves.csv"): (ROOT / "docs" / "track.md", "csv", 0),
    ("docs/workspace.md", "moves.csv"): (ROOT / "docs" / "track.md", "csv", 0),
    ("docs/measure.md", "wanted.csv"): (ROOT / "docs" / "measure.md", "text", 0),
    ("docs/tutorial-machine.md", "path.csv"): (ROOT / "docs" / "tutorial-machine.md", "text", 0),
}


def machine() -> str:
    """Return the hexapod that stands for the machine of a reader."""
    cone = "cone: {axis: [0, 0, 1], half_angle: 60}"
    base = "".join(f"  B{i}: {{point: [{x}, {y}, 0], {cone}}}\n" for i, (x, y, _, _) in _numbered())
    platform = "".join(f"  P{i}: {{point: [{x}, {y}, 0]}}\n" for i, (_, _, x, y) in _numbered())
    rows = "".join(
        f"  - {{distance: [P{i}, B{i}], value: sqrt({(a - x) ** 2 + (b - y) ** 2 + 25}), "
        "range: [3, 9]}\n"
        for i, (x, y, a, b) in _numbered()
    )
    head = "gsp: 1\nname: Stand-in\nunits: {length: mm, angle: deg}\n"
    return f"{head}platform:\n{platform}base:\n{base}constraints:\n{rows}"


def _numbered() -> list[tuple[int, tuple[float, float, float, float]]]:
    return list(enumerate(_JOINTS, start=1))


def _block(page: Path, language: str, number: int) -> str:
    """Return a block of a page; the first of text is the one that is a table."""
    pattern = r"```text\n(t,.*?)```" if language == "text" else rf"```{language}\n(.*?)```"
    blocks: list[str] = re.findall(pattern, page.read_text(encoding="utf-8"), re.DOTALL)
    return blocks[number]


def _platform(shown: Shown) -> str:
    named = _OF_PLACE.get(shown.place) or _MACHINES.get(shown.calls[-1][0])
    if named == "MASSES":
        return _block(_DYNAMICS, "yaml", 0)
    return instance_files()[named].read_text(encoding="utf-8") if named else machine()


def _heights(shown: Shown) -> tuple[float, ...]:
    """Return the heights of a short way of the machine that is meant."""
    middle = {"calibrate": 130.0, "sensors": 400.0, "workspace": 100.0}.get(shown.calls[-1][0], 5.0)
    if "rotary.yaml" in shown.line:
        middle = 0.17
    return tuple(middle * factor for factor in (1, 1.01, 1.02))


def _path(shown: Shown) -> str:
    if "@workspace-study-cones" in shown.line:
        heights: tuple[float, ...] = (60.0, 61.0)
    else:
        heights = _heights(shown)
    form, turn = ("rx,ry,rz", "0,0,0") if "--euler" in shown.line else ("qw,qx,qy,qz", "1,0,0,0")
    rows = "".join(f"{t},0,0,{z},{turn}\n" for t, z in enumerate(heights))
    return f"t,x,y,z,{form}\n{rows}"


def _printed(line: str) -> Callable[[Shown], str]:
    def made(shown: Shown) -> str:
        del shown
        return run_line(line).results

    return made


def _framed(shown: Shown) -> str:
    """Return a machine with the frames that the page about them adds to it."""
    del shown
    stated = _block(ROOT / "docs" / "tables.md", "yaml", 0)
    return instance_files()["workspace-study"].read_text(encoding="utf-8") + stated


def _thick(shown: Shown) -> str:
    """Return a machine with the diameter of legs that the page about gaps adds to it."""
    del shown
    stated = _block(ROOT / "docs" / "workspace.md", "yaml", 0)
    return instance_files()["workspace-study"].read_text(encoding="utf-8") + stated


def _copied(path: Path) -> Callable[[Shown], str]:
    return lambda shown: path.read_text(encoding="utf-8")


def _poses(shown: Shown) -> str:
    if shown.calls[-1][0] == "certify":
        return run_line("gsp solve platform.yaml --all --format csv").results
    return _path(shown)


_MEASURED = ROOT / "docs" / "calibration" / "measured.csv"
#: How each file is made, if the page does not have it.
_FILES: dict[str, Callable[[Shown], str]] = {
    "platform.yaml": _platform,
    "sketch.yaml": _platform,
    "machine.yaml": _copied(data_path("platforms", "workspace-study-cones.yaml")),
    "framed.yaml": _framed,
    "thick.yaml": _thick,
    "rotary.yaml": _copied(data_path("platforms", "t-top-head.yaml")),
    "head.yaml": _copied(data_path("platforms", "t-top-head.yaml")),
    "path.csv": _path,
    "poses.csv": _poses,
    "poses.json": _printed("gsp solve platform.yaml --all --format json"),
    "values.csv": lambda shown: "t,1\n0,5.3\n1,5.4\n",
    "instances.jsonl": lambda shown: json.dumps(yaml.safe_load(machine())) + "\n",
    "log.csv": lambda shown: "Zeit [s],motor 1,x,y,z,qw,qx,qy,qz\n0,7,0,0,5,1,0,0,0\n",
    "forces.csv": lambda shown: "t,F1,F2,F3,F4,F5,F6\n0,25,25,25,25,25,25\n0.1,25,25,25,25,25,25\n",
    "moves.csv": lambda shown: "t,1\n0,5.3\n1,5.4\n",
    "angles.csv": lambda shown: "t,crank.B1\n0,0\n1,5\n",
    "track.csv": lambda shown: run_line("gsp solve platform.yaml --format csv").results,
    "measured.csv": _copied(_MEASURED),
    "tracker.csv": _copied(_MEASURED),
    "level.csv": _copied(_MEASURED.with_name("level.csv")),
    "controller-log.csv": _copied(_MEASURED.with_name("controller-log.csv")),
}


def prepare(shown: Shown, kept: set[str]) -> None:
    """Write into the current folder what a command line reads of the reader's.

    Parameters
    ----------
    shown
        The command line.
    kept
        The names of files that earlier commands have written, which stay.
    """
    data = Path("data")
    if "data/" in shown.line and not data.exists():
        data.symlink_to(ROOT / "data")
    words = {word for words in shown.steps for word in words}
    # The machine comes first: others are made from it.
    for name in _FILES.keys() | {name for place, name in _BLOCKS if place == shown.place}:
        if name not in words and not (name == "platform.yaml" and words & _FROM_PLATFORM):
            continue
        if name not in kept:
            _write(name, shown)


#: What is made by solving ``platform.yaml``.
_FROM_PLATFORM = {"poses.json", "track.csv"}


def _write(name: str, shown: Shown) -> None:
    known = _BLOCKS.get((shown.place, name))
    text = _block(*known) if known else _FILES[name](shown)
    Path(name).write_text(text, encoding="utf-8")
