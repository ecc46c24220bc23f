"""Time machines with cranks and slides in Python, and compare other platforms with before.

    python -m benchmarks.drives [--poses 10000]
    python -m benchmarks.drives --against CHECKOUT [--commands measure,track,...] [--turns 3]
        [NAME ...]

Without --against it prints seconds of processor time for each shipped machine with cranks or
slides. They are those for the numbers of the drives of 10 000 poses, and for their torques under
the weights of all bodies and under a load. The best of five runs in one process counts.

With --against: another version of `gsp`, built with its virtual environment in CHECKOUT/.venv. Both
run the commands that people use on each shipped platform without cranks or slides (or on each
NAME), in turns. The outputs (standard output, errors, exit code, files) must be the same, byte for
byte: else the first line that differs is printed. The processor times of both are compared by
command, over all platforms, as the sum of the least of the turns. The exit code is 1 if an output
differs, or a command takes more than `SLOWER` times as much.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gspcli
from benchmarks.processes import Finished, run
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_vector
from gspcli.motion import drive_values, measure
from gspcli.resources import data_path, instance_files

Array = NDArray[np.float64]

#: A command may take this many times what it took.
SLOWER = 1.05
#: Rows of the files of poses and values.
ROWS = 200
_RUNS = 5
#: What is compiled in the first turn is written, so that the least of the turns is without that.
_ENVIRONMENT = {
    "COLUMNS": "120",
    "NO_COLOR": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONDONTWRITEBYTECODE": "",
}
_MASSES = """
dynamics:
  platform: {mass: 12, centre: [0, 0, 0], inertia: [1, 1, 1, 0, 0, 0]}
  drives: {inertia: 0.4, stiffness: 2.0e6}
"""
_COMMANDS: dict[str, tuple[str, ...]] = {
    "measure": ("measure", "{spec}", "{poses}"),
    "track": ("track", "{spec}", "{values}"),
    "analyze": ("analyze", "{spec}", "{poses}", "--load", "1,2,3,4,5,6"),
    "analyze home": ("analyze", "{spec}", "--mode", "home", "--load", "1,2,3,4,5,6"),
    "workspace": ("workspace", "{spec}"),
    "clearance": ("clearance", "{spec}"),
    "dynamics": ("dynamics", "{masses}", "{poses}"),
    "modes": ("dynamics", "{masses}", "{poses}", "--modes"),
    "mjcf": ("export", "{spec}", "--to", "mjcf"),
    "c": ("export", "{spec}", "--to", "c", "--prefix", "machine"),
}


def main() -> int:
    """Measure, or compare; return the exit code."""
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("names", nargs="*", metavar="NAME", help="shipped platforms")
    options.add_argument("--poses", type=int, default=10_000, help="this many (10000)")
    options.add_argument("--against", type=Path, metavar="CHECKOUT", help="another version")
    options.add_argument("--commands", default=",".join(_COMMANDS), help="only these")
    options.add_argument("--turns", type=int, default=3, help="of both versions (3)")
    given = options.parse_args()
    files = {name: data_path(f"platforms/{name}.yaml") for name in _shipped()}
    chosen = given.names or list(files)
    unknown = [*{*chosen} - {*files}, *{*given.commands.split(",")} - {*_COMMANDS}]
    if unknown:
        options.error(f"found {', '.join(unknown)}, expected {', '.join((*files, *_COMMANDS))}")
    if given.against is None:
        return _measured({name: files[name] for name in chosen}, given.poses)
    plain = {name: files[name] for name in chosen if not Machine.of(gspcli.load(files[name])).moves}
    return _compared(plain, given.against, given.commands.split(","), given.turns)


def _shipped() -> list[str]:
    return sorted(
        name for name, path in instance_files().items() if path.parent.name == "platforms"
    )


def _measured(files: dict[str, Path], count: int) -> int:
    """Print what poses cost in Python."""
    print(f"{count} poses, seconds of processor time:  numbers  torques of weights  of a load")
    for name, path in files.items():
        instance = gspcli.load(path)
        if not Machine.of(instance).moves:
            continue
        weighed = gspcli.loads(_weighed(path))
        R, T = _poses(instance, count, 0.02)
        calls: tuple[Callable[[], object], ...] = (
            lambda instance=instance, R=R, T=T: drive_values(instance, R, T),
            lambda instance=weighed, R=R, T=T: gspcli.inverse_dynamics(instance, R, T).torques,
            lambda instance=instance, R=R, T=T: _torques(instance, R, T),
        )
        print(f"{name:36}", *(f"{_least(call):8.3f}" for call in calls), flush=True)
    return 0


def _torques(instance: Instance, R: Array, T: Array) -> object:
    return gspcli.analyze(instance, R, T, load=[0, 0, -10]).torques


def _least(call: Callable[[], object]) -> float:
    """Return the least processor time of some calls, in seconds."""
    times = []
    for _ in range(_RUNS):
        began = time.process_time()
        call()
        times.append(time.process_time() - began)
    return min(times)


def _poses(instance: Instance, count: int, spread: float) -> tuple[Array, Array]:
    """Return random poses about home, turned by radians and moved by parts of the size."""
    home = gspcli.solve(instance).home
    if home is None:
        home = gspcli.solve(instance).real_solutions[0]
    rng, size = np.random.default_rng(7), Arrangement.of(instance).length
    turned = rotation_from_vector(spread * rng.uniform(-1, 1, (count, 3)))
    return turned @ home.R.real, home.T.real + spread * size * rng.uniform(-1, 1, (count, 3))


def _weighed(path: Path) -> str:
    """Return a machine with masses; a length unit that is none of physics becomes the metre."""
    text = path.read_text(encoding="utf-8")
    return text.replace("length: unit", "length: m").rstrip() + "\n" + _MASSES


def _compared(files: dict[str, Path], other: Path, commands: list[str], turns: int) -> int:
    """Compare outputs and processor times with those of another version."""
    programs = (Path(sys.executable).with_name("gsp"), other / ".venv" / "bin" / "gsp")
    times = defaultdict(lambda: np.zeros(2))
    different = 0
    for name, path in files.items():
        with tempfile.TemporaryDirectory() as folder:
            words = _inputs(path, Path(folder))
            for command in commands:
                line = [word.format(**words) for word in _COMMANDS[command]]
                if command == "c":
                    line += ["-o", f"{folder}/machine.c"]
                least, said = np.full(2, np.inf), ["", ""]
                for _, k in itertools.product(range(turns), (0, 1)):
                    done = run([programs[k], *line], more=_ENVIRONMENT)
                    least[k], said[k] = min(least[k], done.cpu), _all_of(done, Path(folder))
                times[command] += least
                different += said[0] != said[1]
                if said[0] != said[1]:
                    print(f"{name}, {command}: {_first_difference(*said)}", flush=True)
    print("processor time of all platforms, s: now, before, ratio")
    for command, (now, before) in times.items():
        print(f"{command:14} {now:8.2f} {before:8.2f} {now / before:8.3f}")
    slower = [command for command, (now, before) in times.items() if now > SLOWER * before]
    print(f"{different} outputs differ; slower: {', '.join(slower) or 'none'}")
    return int(bool(different or slower))


def _inputs(path: Path, folder: Path) -> dict[str, str]:
    """Write what the commands read: an instance with masses, poses and values."""
    instance = gspcli.load(path)
    R, T = _poses(instance, ROWS, 0.01)
    poses = np.concatenate((T, quaternion_from_rotation(R)), axis=1)
    # From home, along which a track is followed.
    values = measure(instance, R, T)[:20]
    values = np.vstack((measure(instance, *_home(instance)), values))
    tables = {"poses": ("x,y,z,qw,qx,qy,qz", poses), "values": ("1,2,3,4,5,6", values)}
    words = {"spec": str(path), "masses": str(folder / "masses.yaml")}
    for name, (heading, rows) in tables.items():
        words[name] = str(folder / f"{name}.csv")
        np.savetxt(words[name], rows, fmt="%.17g", delimiter=",", header=heading, comments="")
    Path(words["masses"]).write_text(_weighed(path), encoding="utf-8")
    return words


def _home(instance: Instance) -> tuple[Array, Array]:
    R, T = _poses(instance, 1, 0.0)
    return R, T


def _all_of(done: Finished, folder: Path) -> str:
    """Return what a command said and wrote."""
    files = [path.read_text("utf-8") for path in sorted(folder.glob("machine.*"))]
    return "\n".join((done.output, done.errors, done.trouble, *files))


def _first_difference(now: str, before: str) -> str:
    lines = itertools.zip_longest(now.splitlines(), before.splitlines(), fillvalue="")
    a, b = next(((a, b) for a, b in lines if a != b), ("line ends", ""))
    return f"now\n    {a}\nbefore\n    {b}"


if __name__ == "__main__":
    sys.exit(main())
