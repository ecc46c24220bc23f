"""Record which one more sensor tells the modes of real machines apart, for docs/sensors.md.

    python -m tools.verify.sensors [--jobs 2] [--check [--sample N]]

For each machine of ``data/platforms`` it is counted for how many sets of values each sensor
suffices (`gspcli.sensors` with its defaults). The sets are the values of its file, and `COUNT`
random ones. The side of the base on which the platform is, is known or not. The record is
``data/verification/sensors.csv``, from which the tables of ``docs/sensors.md`` are made. Three
facts must hold where base and platform are planar. Each leg between joints is proved never to
suffice, and its readings at two modes of every set are equal within rounding. Some angle of a joint
and the inclinometer suffice for most sets. If the side is known, some leg suffices for nearly all
sets.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from platform import python_version

import numpy as np

from gspcli import __version__
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, NotFiniteError
from gspcli.sensing import SensorResult, sensors
from gspcli.spec import load
from gspcli.workers import Workers
from tools.recording import ROOT, add_sample, csv_text, parser, report, sampled, save, with_section

PLATFORMS = ROOT / "data" / "platforms"
RECORD = ROOT / "data" / "verification" / "sensors.csv"
PAGE = ROOT / "docs" / "sensors.md"
COUNT = 200
#: The group of the best two sensors, which are sought where no single one suffices always.
TWO = "best two"
#: Readings that differ by no more standard deviations are the same but for rounding.
SAME = 1e-6
#: What is asked of planar machines: the shares of sets for which something suffices, at least.
JOINT, INCLINOMETER, SOME_LEG = 0.85, 0.8, 0.9
#: Which values, and whether the side is known.
CASES = (("given", False), ("random", False), ("random", True))


@dataclass(frozen=True)
class Row:
    """What the sensors of one group do for one machine.

    Attributes
    ----------
    platform, case, known_side
        The machine, ``given`` or ``random`` values, and whether the side of the base is known.
    drawn
        The origin of the values, or why there are none.
    sets, told
        Sets of values, and how many of them have more than one mode.
    modes
        The least and the largest number of modes.
    planar
        Whether base and platform are planar, proved, and each mode has a mirror image.
    group, sensors, blind
        The sort of sensor, how many there are, and how many are proved never to suffice.
    best, share, median
        The best of them; for which part of the sets with several modes it suffices; and the median,
        over the sets, of the least difference of two modes in standard deviations.
    any
        For which part of the sets some sensor of the sort suffices.
    """

    platform: str
    case: str
    known_side: bool
    drawn: str
    sets: int = 0
    told: int = 0
    modes: str = ""
    planar: bool = False
    group: str = ""
    sensors: int = 0
    blind: int = 0
    best: str = ""
    share: str = ""
    median: str = ""
    any: str = ""


def examine(key: tuple[str, str, bool]) -> tuple[list[Row], list[str]]:
    """Return the rows of a machine in a case, and what does not hold that must."""
    name, case, known_side = key
    instance = load(PLATFORMS / f"{name}.yaml")
    count = COUNT if case == "random" else None
    try:
        result = sensors(instance, random=count, known_side=known_side, seed=SEED)
    except (ArgumentError, NotFiniteError) as error:
        reason = str(error).removeprefix("instance: ").removeprefix("known_side: ")
        return [Row(name, case, known_side, reason)], []
    rows = [_row(result, name, case, group) for group in result.groups]
    rows += [_pair_row(result, rows[0])] if result.pair else []
    return rows, [f"{key}: {wrong}" for wrong in _wrong(result)]


def _row(result: SensorResult, name: str, case: str, group: str) -> Row:
    chosen = result.in_group(group)
    best, found = chosen[0], result.separations
    return Row(
        name,
        case,
        result.known_side,
        result.drawn,
        len(result.values),
        int(result.told.sum()),
        f"{found.modes.min()}-{found.modes.max()}",
        result.mirror is not None,
        group,
        len(chosen),
        int(result.blind[chosen].sum()),
        str(result.sensors[best]),
        f"{result.shares[best]:.3f}",
        # Two digits: the last ones depend on the processor.
        f"{_clean(result.quantile(0.5)[best]):.2g}",
        f"{result.any_of(group):.3f}",
    )


def _pair_row(result: SensorResult, like: Row) -> Row:
    """Return the row of the best two sensors together."""
    assert result.pair is not None
    told = result.pair.least[result.told]
    share = f"{(told >= result.need).mean():.3f}"
    both = " and ".join(str(result.sensors[k]) for k in result.pair.sensors)
    median = f"{_clean(float(np.median(told))):.2g}"
    pairs = len(result.sensors) * (len(result.sensors) - 1) // 2
    return replace(
        like, group=TWO, sensors=pairs, blind=0, best=both, share=share, median=median, any=""
    )


def _clean(value: float) -> float:
    return 0.0 if value < SAME else value


def _wrong(result: SensorResult) -> Iterable[str]:
    """Yield violations: sets that are not complete, and wrong statements about planar machines."""
    found = result.separations
    if not found.complete.all():
        yield f"{int((~found.complete).sum())} sets are not complete"
    if result.mirror is None:
        return
    blind = found.least[result.blind][:, result.told]
    if blind.size and blind.max() > SAME:
        yield "a sensor that is proved blind tells mirror images apart"
    shares = {group: result.any_of(group) for group in result.groups}
    if result.known_side:
        if shares["leg"] < SOME_LEG:
            yield f"with the side known some leg suffices for {shares['leg']:.0%} of the sets only"
    else:
        if not result.blind[result.in_group("leg")].all():
            yield "a leg between joints is not proved blind"
        if result.drawn != "given" and (
            shares["joint"] < JOINT or shares["inclinometer"] < INCLINOMETER
        ):
            yield f"other sensors suffice too seldom: {shares}"


def written(rows: Sequence[Row]) -> str:
    """Return the record."""
    return csv_text([{k: str(v) for k, v in asdict(row).items()} for row in rows])


def manifest(record: str) -> str:
    """Return how the record was made, as JSON."""
    document = {
        "command": "python -m tools.verify.sensors",
        "seed": SEED,
        "sha256": hashlib.sha256(record.encode()).hexdigest(),
        "versions": {"gsp": __version__, "numpy": np.__version__, "python": python_version()},
    }
    return json.dumps(document, indent=1) + "\n"


def tables(rows: Sequence[Row]) -> str:
    """Return the tables of the page: at random values, and at those of the files."""
    without = {row.platform: row.drawn for row in reversed(rows) if not row.group}
    lines = []
    for case in ("random", "given"):
        lines += [*_HEADINGS[case], *map(_line, _by_machine(rows, case)), ""]
    lines += ["Without random values, or sides:", ""]
    lines += [f"- {name}: {reason}" for name, reason in sorted(without.items())]
    return "\n".join(lines)


_GROUPS = ("leg", "leg to a point", "coordinate", "joint", "inclinometer", TWO)
_NAMES = " | ".join(_GROUPS)
_RULES = "|".join("---:" for _ in _GROUPS)
_HEADINGS = {
    "random": [f"| machine | planar | sets | modes | {_NAMES} |", f"|---|---|---:|---|{_RULES}|"],
    "given": [f"| machine | planar | modes | {_NAMES} |", f"|---|---|---|{_RULES}|"],
}


def _by_machine(rows: Sequence[Row], case: str) -> list[list[Row]]:
    """Return the rows of each machine in a case, those with the side known after the others."""
    chosen: dict[tuple[str, bool], list[Row]] = {}
    for row in rows:
        if row.case == case and row.group:
            chosen.setdefault((row.platform, row.known_side), []).append(row)
    return list(chosen.values())


def _line(rows: Sequence[Row]) -> str:
    """Return a line of a table."""
    first = rows[0]
    cells = {row.group: _cell(row) for row in rows}
    name = first.platform + (", known side" if first.known_side else "")
    sets = [f"{first.told}"] if first.case == "random" else []
    modes = "–".join(dict.fromkeys(first.modes.split("-")))
    parts = [name, "yes" if first.planar else "", *sets, modes]
    return f"| {' | '.join([*parts, *(cells.get(group, '') for group in _GROUPS)])} |"


def _cell(row: Row) -> str:
    """Return how often the best sensor suffices and, in brackets, some sensor of the sort."""
    if row.blind == row.sensors:
        return "never"
    if row.case == "given":
        text = f"{float(row.median):g} σ"
        return text if row.share == "1.000" else f"no: {text}"
    text = f"{100 * float(row.share):.3g} %"
    return text if row.sensors == 1 or not row.any else f"{text} ({100 * float(row.any):.3g} %)"


def main() -> int:
    """Record or compare; return the exit code."""
    options = parser(__doc__)
    add_sample(options)
    options.add_argument("--jobs", type=int, default=1, help="processes")
    arguments = options.parse_args()
    every = sorted(path.stem for path in PLATFORMS.glob("*.yaml"))
    names = sampled(every, arguments.sample if arguments.check else None)
    keys = [(name, *case) for name in names for case in CASES]
    examined = list(Workers(arguments.jobs).in_order(examine, keys))
    rows = [row for some, _ in examined for row in some]
    wrong = [text for _, texts in examined for text in texts]
    summary = f"{len(names)} machines, {len(rows)} rows"
    if len(names) < len(every):
        lines = set(RECORD.read_text(encoding="utf-8").splitlines())
        return report(
            [*(line for line in written(rows).splitlines() if line not in lines), *wrong], summary
        )
    record = written(rows)
    page = with_section(PAGE, "tables", tables(rows))
    files = {RECORD: record, RECORD.with_suffix(".manifest.json"): manifest(record), PAGE: page}
    code = save(files, check=arguments.check, confirmed=summary)
    return report(wrong, "what must hold") or code


if __name__ == "__main__":
    sys.exit(main())
