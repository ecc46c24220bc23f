"""Mutated files of machines: none may end in a traceback, and what is read must hold.

Files of all formats are made from one platform; each run changes some of their bytes, numbers or
words. What is still read is checked: its text gives the same instance, and each constraint stays
the same over random motions of its chain that the recognition has not seen.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random

import numpy as np

import gspcli
from gspcli.errors import GspError
from gspcli.geometry.instance import Instance
from gspcli.machines.chain_constraints import moved, random_changes
from gspcli.machines.formats import machine_of
from gspcli.machines.kinds import measured
from gspcli.machines.recognition import Machine, recognized

#: What numbers and words become.
_NUMBERS = ("0", "-1", "nan", "inf", "1e308", "1e-320", "-0.0", "", "1 2", "0x1p3", "1e999", "٣")
_WORDS = ("", "world", "base", "joint", "ball", "fixed", "&amp;", "<", "]]>", "\x00", "é", "../x")
#: A constraint may change by this much more than over the motions by which it was found.
_SLACK, _LEAST = 30.0, 1e-7


def corpus(folder: Path) -> Iterator[list[Path]]:
    """Yield the files of each format; the first of them is read."""
    instance = gspcli.example("nano-hexapod")
    for form in ("mjcf", "sdf", "urdf"):
        made = gspcli.exported(instance, form)
        names = [folder / form / f"robot{suffix or '.xml'}" for suffix in made.files]
        names[0].parent.mkdir()
        for path, text in zip(names, made.files.values(), strict=True):
            path.write_text(text, encoding="utf-8")
        yield names[::-1]
    base = [[round(float(x), 3) for x in row.base.point] for row in instance.constraints]
    top = [[round(float(x), 3) for x in row.platform.point] for row in instance.constraints]
    lengths = [round(row.value.value, 3) for row in instance.constraints]
    texts = {
        "tables/joints.csv": "name;bx [m];by;bz;px;py;pz;length\n"
        + "\n".join(
            ";".join(map(str, (k, *b, *p, length)))
            for k, (b, p, length) in enumerate(zip(base, top, lengths, strict=True))
        ),
        "cuik/hexapod.world": "[CONSTANTS]\n h := 1/2\n[LINKS]\n a :\n b :\n[JOINTS]\n"
        + "".join(
            f" sph_prs_sph : a ({', '.join(map(str, b))}) b ({', '.join(map(str, p))}) "
            f"length h*{2 * length} range [0, 3]\n"
            for b, p, length in zip(base, top, lengths, strict=True)
        ),
        "hal/kins.hal": "".join(
            f"setp genhexkins.{body}.{i}.{axis} {x}\n"
            for body, points in (("base", base), ("platform", top))
            for i, point in enumerate(points)
            for axis, x in zip("xyz", point, strict=True)
        ),
        "hal/machine.ini": "[KINS]\nKINEMATICS = genhexkins\n[TRAJ]\nLINEAR_UNITS = mm\n"
        "HOME = 0 0 0.09 0 0 0\n[JOINT_0]\nMIN_LIMIT = 0\nMAX_LIMIT = 2\n",
        "caspr/r_cables.xml": '<cables default_cable_set="s"><cable_set id="s">'
        + "".join(
            f'<cable_ideal name="c{k}"><properties><force_min>1</force_min><force_max>9</force_max>'
            f"</properties><attachments><attachment><link>0</link><location>{' '.join(map(str, b))}"
            "</location></attachment><attachment><link>1</link><location>"
            f"{' '.join(map(str, p))}</location></attachment></attachments></cable_ideal>"
            for k, (b, p) in enumerate(zip(base, top, strict=True))
        )
        + "</cable_set></cables>",
        "caspr/r_bodies.xml": '<bodies_system><links><link_rigid name="p"><joint type="SPATIAL_EULE'
        'R_XYZ" q_initial="0 0 0.09 0 0 0"/><physical><mass>1</mass><com_location>0 0 0'
        "</com_location></physical></link_rigid></links></bodies_system>",
    }
    for name, text in texts.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    for group in (("tables/joints.csv",), ("cuik/hexapod.world",),
                  ("hal/kins.hal", "hal/machine.ini"),
                  ("caspr/r_cables.xml", "caspr/r_bodies.xml")):  # fmt: skip
        yield [folder / name for name in group]


def mutated(content: bytes, random: Random) -> bytes:
    """Return content with one to three changes."""
    for _ in range(random.randint(1, 3)):
        change: Callable[[bytes, Random], bytes] = random.choice(
            (_flipped, _cut, _doubled, _number, _number, _number, _word, _word, _swapped)
        )
        content = change(content, random)
    return content


def _place(content: bytes, random: Random) -> int:
    return random.randrange(max(1, len(content)))


def _flipped(content: bytes, random: Random) -> bytes:
    at = _place(content, random)
    return content[:at] + bytes([random.randrange(256)]) + content[at + 1 :]


def _cut(content: bytes, random: Random) -> bytes:
    at = _place(content, random)
    return content[:at] + content[at + random.choice((1, 5, 60, 10**6)) :]


def _doubled(content: bytes, random: Random) -> bytes:
    at, length = _place(content, random), random.choice((1, 8, 300))
    return content[: at + length] + content[at : at + length] + content[at + length :]


def _pieces(content: bytes, pattern: bytes) -> list[tuple[int, int]]:
    import re

    return [match.span() for match in re.finditer(pattern, content)]


def _replaced(content: bytes, random: Random, pattern: bytes, words: tuple[str, ...]) -> bytes:
    spans = _pieces(content, pattern)
    if not spans:
        return content
    start, end = random.choice(spans)
    return content[:start] + random.choice(words).encode() + content[end:]


def _number(content: bytes, random: Random) -> bytes:
    near = tuple(f"{random.uniform(-1, 1) * 10.0 ** random.randint(-9, 3):.9g}" for _ in range(12))
    return _replaced(content, random, rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?", _NUMBERS + near)


def _word(content: bytes, random: Random) -> bytes:
    return _replaced(content, random, rb"[A-Za-z_]\w+", _WORDS)


def _swapped(content: bytes, random: Random) -> bytes:
    spans = _pieces(content, rb"[\w.]+")
    if len(spans) < 2:
        return content
    (a, b), (c, d) = sorted(random.sample(spans, 2))
    return content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]


def holds(machine: Machine) -> bool:
    """Return whether the constraints stay the same over motions of their chains."""
    rng = np.random.default_rng(12345)
    chains = {(chain.name, chain.letters): chain for chain in machine.structure.chains}
    for found in machine.constraints:
        chain, held = chains[found.chain, found.letters], found.held
        for _ in range(4):
            X = moved(chain, random_changes(chain, chain.size, rng))
            value = float(measured(held.kind, held.platform, held.base, X)[0, 0])
            scale = 1.0 if held.kind[0] == "A" else chain.size
            if abs(value - held.value) > max(_SLACK * held.change, _LEAST * scale):
                return False
    return True


def read(path: Path) -> str:
    """Return the result for a file: refused, the stored instance, or a machine that holds."""
    try:
        found = gspcli.import_machine(path)
        graph = machine_of(path)
    except (GspError, OSError) as error:
        return f"refused ({type(error).__name__})" if str(error) else "WRONG: no message"
    if gspcli.loads(found.text) != found.instance:
        return "WRONG: the text is another instance"
    if isinstance(graph, Instance):
        return "stored"
    machine = recognized(graph)
    names = [chain.name for chain in machine.structure.chains]
    if len(set(names)) < len(names):
        return "read (names twice)"
    return "read" if holds(machine) else "WRONG: a constraint that does not hold"


def main() -> int:
    """Run this many mutated files of all formats."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--check", action="store_true", help="done in any case")
    parser.add_argument("--sample", type=int, metavar="N", help="only this many")
    options = parser.parse_args()
    options.count = options.sample or options.count
    warnings.simplefilter("ignore")
    random, outcomes = Random(options.seed), Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        groups = list(corpus(Path(name)))
        for group in groups:
            if "refused" in (outcome := read(group[0])):
                print(f"{group[0].name} is {outcome} unchanged")
                return 1
        contents = {path: path.read_bytes() for group in groups for path in group}
        for number in range(options.count):
            group = groups[number % len(groups)]
            victim = random.choice(group)
            victim.write_bytes(mutated(contents[victim], random))
            try:
                outcome = read(group[0])
            except Exception:
                outcome = "WRONG: a traceback"
                traceback.print_exc()
            if "WRONG" in outcome:
                kept = (
                    Path(tempfile.gettempdir()) / f"gsp-fuzz-{options.seed}-{number}-{victim.name}"
                )
                kept.write_bytes(victim.read_bytes())
                print(number, outcome, kept, flush=True)
            outcomes[f"{group[0].parent.name}: {outcome}"] += 1
            victim.write_bytes(contents[victim])
    for outcome, count in sorted(outcomes.items()):
        print(f"{count:6d} {outcome}")
    if any("WRONG" in outcome for outcome in outcomes):
        return 1
    print(f"confirmed: {options.count} mutated files are read rightly or refused")
    return 0


if __name__ == "__main__":
    sys.exit(main())
