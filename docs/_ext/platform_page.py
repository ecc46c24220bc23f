"""The page of real platforms: the real platforms of `data/platforms` with their counts."""

from __future__ import annotations

from pathlib import Path

from gspcli.cli.commands.example import short_name
from gspcli.geometry.instance import Constraint, Instance
from gspcli.resources import data_json, instance_files
from gspcli.spec import load, sharing
from gspcli.spec.form_of_instance import SCHEMA_LINE

FOLDER = "platforms"
HEAD = """\
# Real platforms

These machines with published dimensions come with `gsp` as instance files. `gsp example` lists
them, and `gsp example NAME` prints one. All commands take `@NAME` in place of a file, as in
`gsp solve @rubin-m2`. The numbers are those of the sources. Radii and angles are kept where the
source states them. The values are exactly those of the home position, which the comment of the file
states. The drawings are made by `gsp view @NAME -o FILE.svg`.

"""
LEGEND = """
- *type*: the generic count, for the sides in the file. Almost every platform of the type has this
  number of complex poses; proved.
- *geometry*: the count for these joints with random values.
- *exact*: the count for the values at home, with multiplicities. Both counts are [computed modulo
  a random prime](exact-counts.md), and by Gröbner bases modulo two other primes.
- *real*: the number of assembly modes at home. It is recorded only where the solver finds as many
  poses as the exact count.
- *certified*: how many of all poses are proved, with whether they are real.

`python -m tools.data.example_counts` computes all numbers again. The sides of planes are those
of the machines. Where an exact count is below the count of the type, the geometry is special
(symmetry, shared joints), and the other poses are at infinity.

The two couplings have infinitely many poses. As built they stand still. But the triangle of the
three balls, turned upside down, can move with its corners on the three vees (concurrent lines at
120 degrees).
"""
TAIL = """
## Left out

Other machines have incomplete, guessed or unpublished dimensions, or do not have six constraints.
These were considered:

- the secondary mirrors of the APO 3.5 m telescope (its source marks the radius of the fixed link
  as a guess) and of the SDSS 2.5 m telescope (a central bearing, which is no distance or angle)
- rotary platforms given as parameters of a program and not as joints: Stewart.js, the ESP32
  platform of NicHub, and the motion simulator of Knaufinator
- the Gazebo model of D. Ingram
- the Bosch-Rexroth hexapods of the Norwegian Motion Laboratory (strokes only)
- a servo platform in inches and a six-wire handle, which have no named source
- a Kelvin clamp and a 3-2-1 block, which were constructed and never published (the example
  `fixture-3-2-1` is a 3-2-1 block)

Dietmaier's platform with 40 real poses is the example `dietmaier`.
"""


def page() -> str:
    """Return the text of the page."""
    files = {name: path for name, path in instance_files().items() if path.parent.name == FOLDER}
    records = data_json(FOLDER, "expected.json")["examples"]
    instances = {name: load(path) for name, path in files.items()}
    rows = [
        "| platform | kinds | type | geometry | exact | real | certified |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for name, instance in instances.items():
        record = records[name]
        cells = [
            f"[{name}](#{anchor(name)})",
            short_name(instance.type),
            instance.expected,
            _count(record["geometry"]),
            _count(record),
            record.get("real", ""),
            record.get("certified", ""),
        ]
        rows.append("| " + " | ".join(map(str, cells)) + " |")
    sections = (_section(name, path, instances[name]) for name, path in files.items())
    return HEAD + "\n".join(rows) + "\n" + LEGEND + "".join(sections) + TAIL


def anchor(heading: str) -> str:
    """Return the anchor that a heading has on GitHub and in MyST."""
    kept = (c for c in heading.lower() if c.isalnum() or c in " -")
    return "".join(kept).replace(" ", "-")


def _count(record: dict[str, object]) -> object:
    return "infinite" if record["dimension"] else record["complex"]


def _section(name: str, path: Path, instance: Instance) -> str:
    comments = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        if not line.startswith(SCHEMA_LINE):
            comments.append(line.removeprefix("# "))
    platform, base = sharing(instance)
    shared = [
        f"{body} {primitive} ({' '.join(map(str, numbers))})"
        for body, names in (("platform", platform), ("base", base))
        for primitive, numbers in names.items()
    ]
    text = f"\n## {name}\n\n" + "\n".join(comments) + "\n\n"
    text += f"![{instance.name} at home](images/{FOLDER}/{name}.svg)\n\n"
    text += f"Type {instance.type.number}. Source: {_linked(str(instance.source))}.\n"
    if shared:
        text += f"\nShared by several constraints (their numbers): {', '.join(shared)}.\n"
    text += f"\n| constraint | {instance.units.length} | range |\n|---|---:|---|\n"
    for number, row in enumerate(instance.constraints, 1):
        what = f"{number}: {row.kind.name} {row.platform_name} {row.base_name}"
        text += f"| {what} | {row.value.value:.9g} | {_range(row)} |\n"
    return text


def _linked(source: str) -> str:
    url, _, rest = source.partition(" ")
    if not url.startswith("https://"):
        return source
    return f"<{url.rstrip(':')}>" + (f" {rest}" if rest else "")


def _range(row: Constraint) -> str:
    if row.limits is None:
        return ""
    low, high = (limit.value for limit in row.limits)
    return "fixed" if low == high else f"{low:.9g} to {high:.9g}"
