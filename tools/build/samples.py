"""Runs of all commands, for the pages and checks that look at everything that is printed."""

from __future__ import annotations

import contextlib
import io
import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click

from gspcli.cli.main import cli, run
from gspcli.resources import data_directory, instance_files
from gspcli.spec import load
from tools.recording import ROOT

#: Runs that together print all keys of a command, where the examples of its help do not; POSES,
#: TWICE, VALUES, REACH, LOOP, STATE, MASSES, PATH, ROTARY, THICK and RAILS are files made
#: here.
SAMPLES: dict[str, tuple[str, ...]] = {
    "enumerate": (
        "--class 6D --only PP,PH",
        "--class 3D3A --only PH,HP,A",
        "--class 5D1A --by-class",
        "--coincident --class 4D2A",
        "--coincident 6PP --first 90",
        "--coincident 'DLL DLL DLL ALL ALL ALH' --first 40",
    ),
    "show": ("6PP", "421", "1007", "3D3A PH PH PH ALL ALL ALL"),
    "bound": ("3D3A PL PL LP", "6PP", "3D3A PH PH PH ALL ALL ALL", "1 17"),
    "constraint": ("DPL", "DLL", "ALH", "DPP"),
    "realize": (
        "6PP",
        "DLL DLL DLL ALL ALL ALH",
        "3000",
        "@octahedral-3-3",
        "'P1-p1 P1-p2 P1-p3 P1-p4 P2-p5 P3-p6'",
    ),
    "table": ("1", "2", "3", "errata --check"),
    "derive": ("", "ppp", "ccc"),
    "atlas summary": ("",),
    "example": ("",),
    "check": ("@dietmaier @three-vee-250mm @point-on-line @fixture-3-2-1",),
    "solve": (
        "@dietmaier --all",
        "@figure-3 --all --digits 20",
        "@planar-hexagons --all",
        "@workspace-study-cones --set 6=79",
        "@no-real-pose",
        "@griffis-duffy",
        "@singular-pose",
        "@workspace-study-cones --relative-to home",
        "@workspace-study-cones --within-limits --where z<0",
        "@rubin-m2 --reading 'leg P1 B2 = 2.913 ± 0.002' --reading 'inclinometer = 0, 0 ± 0.1'",
        "@rubin-m2 --reading 'leg P1 B2 = 2.953 ± 0.002' --fit --sigma value=0.001",
    ),
    "sensors": ("@rubin-m2", "@linuxcnc-hexapod", "@no-real-pose", "@workspace-study --known-side"),
    "certify": ("@figure-3 POSES", "@figure-3 POSES --digits 20", "@figure-3 TWICE"),
    "count": (
        "@planar-hexagons @griffis-duffy @six-planes",
        "@dietmaier --effort 0.000001",
        "--type 6PP --geometry generic,3-3",
    ),
    "sample": ("6PP --count 20",),
    "maximize-real": ("3D3A PH PH PH --attempts 1 --resume STATE",),
    "measure": (
        "@figure-3 POSES",
        "@rubin-m2 --pose 0,0,0,1,0,0,0 "
        "--require range,condition<=9,clearance>=2,pose-clearance>=0",
        "@t-top-head --pose 0,0,0.17,1,0,0,0 --cranks",
        "@t-top-head --pose 0,0,0.17,1,0,0,0 --drives",
        "@workspace-study --pose 0,0,900,1,0,0,0 --nearest",
        "THICK --pose 0,0,400,1,0,0,0 --require gap>=2",
    ),
    "track": (
        "@rubin-m2 VALUES",
        "LOOP --allow-loss --complete --clearance --pose-clearance",
        "REACH",
        "REACH --require range,cone",
        "@apo-tertiary FAR --euler xyz",
        "@rubin-m2 VALUES --relative-to home",
        "@modified-paradex RAILS",
    ),
    "path": (
        "@rubin-m2 --from home --to 2",
        "@rubin-m2 --from home --to 0,0,0.001,1,0,0,0",
        "@rubin-m2 --from home --to 0,0,0.001,1,0,0,0 --along poses",
        "THICK --from home --to 10,0,420,1,0,0,0 --leg-gap 5",
        "@workspace-study --from home --to 3 --speed 50 --acceleration 200 --round",
        "@rubin-m2 --from home --to 0,0,0.001,1,0,0,0 --speed motors=1,platform=1,turn=9 "
        "--acceleration motors=1,platform=1,turn=9",
        "@three-prs --from home --to 0,0,4.5,1,0,0,0 --speed 1 --acceleration 1",
        "@surfaces-sss --all",
        "@workspace-study --all --time 0.01",
        "@workspace-study-cones --all",
    ),
    "analyze": (
        "@rubin-m2",
        "@figure-3",
        "@figure-3 --geometry-tolerance 0.01,0.001",
        "@example-6.8 --load 0,0,-1 --stiffness 1 --tolerance 0.001",
        "@rubin-m2 VALUES --require range,condition<=9,clearance>=0.1,pose-clearance>=0",
        "@workspace-study-cones --require cone",
        "@t-top-head --load 0,0,-9 --require transmission>=0.1,torque<=9",
    ),
    "dynamics": (
        "MASSES",
        "MASSES PATH --require force<=40",
        "MASSES --pose 0,0,0,1,0,0,0",
        "MASSES --pose 0,0,1e-7,1,0,0,0",
        "MASSES --modes --require frequency>=20",
        "MASSES --pose 0,0,1e-7,1,0,0,0 --modes",
        "MASSES --pose 0,0,0,1,0,0,0 --modes",
        "ROTARY --mode home --require torque<=2",
        "ROTARY --mode home --modes",
    ),
    "clearance": (
        "@octahedral-3-3 --mode 1",
        "@singular-pose --mode 1",
        "@surfaces-ppp --mode 1",
        "@octahedral-3-3 --mode 1 --of pose",
        "@rubin-m2 VALUES --mode 2",
        "@reachy-mini-head --of drives",
        "@three-prs --of drives",
    ),
    "scan": (
        "@octahedral-3-3 --vary 1=1:2:5",
        "@t-top-head --vary crank.B1=-60:60:3",
        "@octahedral-3-3 --vary 1=1:2:3 --vary 2=1:2:3",
        "@octahedral-3-3 --vary 1=1:2:5 --folds",
        "@platform-6-6 --vary 1=2.2:2.4:2 --vary 4=1.6:1.8:2 --folds --jobs 1",
        "@platform-6-6 --vary 1=2.4:2.6:3 --quantity clearance",
        "@platform-6-6 --vary x=-2:2:5 --vary y=-2:2:5 --pose 0,0,0.5,1,0.2,0.1,0",
        "@platform-6-6 --vary x=-2:2:5 --vary y=-2:2:5 --pose 0,0,0.5,1,0.2,0.1,0 --folds",
        "@platform-6-6 --vary x=-2:2:3 --pose 0,0,0.5,1,0.2,0.1,0 --quantity clearance",
    ),
    "workspace": (
        "@workspace-study",
        "@workspace-study --relative-to home",
        "@workspace-study --shift z=0:200:2",
        "@workspace-study --over x,y --boxes --gap 0.5",
        "@workspace-study --position 0,0,400 --gap 0.5",
        "@workspace-study --over z --within z=0:100",
        "THICK --over z --within z=0:100 --leg-gap 5",
    ),
    "freedoms": ("@workspace-study", "@singular-pose"),
    "calibrate": (
        "@workspace-study-cones MEASURED --sigma value=0.002 --sigma position=0.005",
        "@workspace-study-cones MEASURED --robust --hold offset.1",
        "@workspace-study-cones --plan 3",
        "@t-top-head --plan 3",
        "@modified-paradex --plan 3",
        "--from CONTROLLER",
    ),
}
#: Where a platform with masses stands, rows of poses and rows of forces.
_PAGE = Path(__file__).resolve().parents[2] / "docs" / "dynamics.md"
#: Takes hours, or prints what only a wrong record makes it print.
_LONG: set[str] = set()
#: Values after which the platform is in another mode, and folds of others on the way.
_LOOP = data_directory() / "trajectories" / "mode-change"
#: Made-up measurements of a real machine.
_MEASURED = ROOT / "docs" / "calibration" / "measured.csv"
_FAR = "x,y,z,rx,ry,rz\n2,-2,-43,21,0,0\n9,-12,-81,-21,0,0\n"
#: All carriages go up, in the end beyond their ranges.
_RAILS = "\n".join(
    [",".join(f"slide.B{k}" for k in range(1, 7)), *(",".join([x] * 6) for x in ("0", "1.6")), ""]
)
#: Exit codes that go with complete output: done, a check failed, not finite, not completed.
_ANSWERS = (0, 1, 3, 4)
#: What stands in examples for a file of the reader, or needs a shell.
_NOT_HERE = re.compile(r"\.[a-z]|[|<>]| -o ")


def described() -> dict[str, click.Command]:
    """Return the commands that print JSON, or write it to a file, by their names."""
    return {
        name: command
        for name, command in commands()
        if name not in _LONG and ("json" in choices(command, "format") or name in SAMPLES)
    }


def commands(group: click.Group = cli, above: str = "") -> Iterator[tuple[str, click.Command]]:
    """Yield all commands by their names, such as ``atlas summary``, in the order of the help."""
    with click.Context(group) as context:
        for name in group.list_commands(context):
            command = group.get_command(context, name)
            if isinstance(command, click.Group):
                yield from commands(command, f"{above}{name} ")
            elif command is not None:
                yield above + name, command


def choices(command: click.Command, option: str) -> tuple[str, ...]:
    """Return what can be chosen by an option of a command: nothing if it has no such option."""
    found = (parameter.type for parameter in command.params if f"--{option}" in parameter.opts)
    return next((tuple(t.choices) for t in found if isinstance(t, click.Choice)), ())


def samples(name: str, command: click.Command) -> tuple[str, ...]:
    """Return runs of a command, without its name."""
    if name in SAMPLES:
        return SAMPLES[name]
    examples = re.findall(rf"^ *gsp {name}\b *(.*)$", command.help or "", re.M)
    return tuple(example for example in examples if not _NOT_HERE.search(example))


def words(name: str, sample: str, folder: Path) -> list[str]:
    """Return a run of a command as words; files that it reads are written to a folder."""
    names = {
        "POSES": "poses.json",
        "TWICE": "twice.json",
        "VALUES": "values.csv",
        "STATE": "s.json",
        "FAR": "far.csv",
        "RAILS": "rails.csv",
    }
    paths = {word: folder / name for word, name in names.items()}
    paths["MEASURED"] = _MEASURED
    paths["CONTROLLER"] = _MEASURED.with_name("controller-log.csv")
    if "POSES" in sample or "TWICE" in sample:
        text = output(["solve", "@figure-3", "--format", "json"])
        paths["POSES"].write_text(text, encoding="utf-8")
        first = json.loads(text)["solutions"][0]
        rough = first | {"certified": False, "T": [value + 3 for value in first["T"]]}
        twice = {"schema": "gsp.solve/1", "solutions": [first, first, rough]}
        paths["TWICE"].write_text(json.dumps(twice), encoding="utf-8")
    if "VALUES" in sample:
        rows = load(instance_files()["rubin-m2"]).constraints
        lines = [",".join(repr(row.value.value + k / 1000) for row in rows) for k in range(3)]
        paths["VALUES"].write_text("\n".join([",".join("123456"), *lines]) + "\n", encoding="utf-8")
    if "REACH" in sample:
        # To the side until legs leave their cones, then up until they are too long.
        poses = [f"{x},0,{z},1,0,0,0" for x, z in ((0, 60), (60, 60), (0, 60), (0, 160))]
        path = folder / "reach.csv"
        path.write_text("\n".join(["x,y,z,qw,qx,qy,qz", *poses]) + "\n", encoding="utf-8")
        sample = sample.replace("REACH", f"@workspace-study-cones {path} --near 0,0,60,1,0,0,0")
    if "FAR" in sample:
        # Two poses so far apart that the way of the values leads to another pose.
        paths["FAR"].write_text(_FAR, encoding="utf-8")
    if "RAILS" in sample:
        paths["RAILS"].write_text(_RAILS, encoding="utf-8")
    if "MASSES" in sample or "ROTARY" in sample:
        page = _PAGE.read_text(encoding="utf-8")
        blocks = re.findall(r"```(?:yaml|csv)\n(.*?)```", page, re.DOTALL)
        files = {"MASSES": "masses.yaml", "PATH": "path.csv"}
        files["ROTARY"] = "rotary.yaml"
        for (word, file), content in zip(files.items(), blocks, strict=True):
            paths[word] = folder / file
            paths[word].write_text(content, encoding="utf-8")
    if "THICK" in sample:
        paths["THICK"] = folder / "thick.yaml"
        text = instance_files()["workspace-study"].read_text(encoding="utf-8")
        paths["THICK"].write_text(f"{text}\nshapes: {{diameter: 20}}\n", encoding="utf-8")
    sample = sample.replace("LOOP", f"{_LOOP}.yaml {_LOOP}.csv")
    for word, path in paths.items():
        sample = sample.replace(word, str(path))
    return [*name.split(), *shlex.split(sample)]


def output(words: list[str]) -> str:
    """Return what a command prints; that poses are infinitely many, or missing, is an answer."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(io.StringIO()) as errors:
        code = run(words)
    if code not in _ANSWERS or not text.getvalue():
        message = f"gsp {shlex.join(words)}: exit code {code}: {errors.getvalue()}"
        raise SystemExit(message)
    return text.getvalue()
