"""Special and nearly special platforms with their exact counts, and what `gsp` says of them.

    python tools/verify_special.py count [--only PATTERN] [--jobs N] [--check [--sample N]]
    python tools/verify_special.py solve [--only PATTERN] [--jobs N] [--seeds N] [--sample N]
    python tools/verify_special.py show ID ...

`count` makes the platforms anew and counts their poses exactly (`special_counts`); the table is
``data/verification/special-platforms.csv``. Rows of unchanged platforms are kept without --check.
`solve` solves them and judges every answer by the table. Its exit code is 1 if any answer is wrong:

wrong complete
    complete, but not the number of poses, or the set is infinite
false infinite
    infinite, but the set is finite
wrong multiplicity
    the number of poses is right, that with multiplicity is not
wrong real
    another number of real poses
too many
    more poses found, or more proved, than there are
seeds
    the answers differ from seed to seed

An answer `incomplete` is honest, if it claims no more than there is. PATTERN is a part of the ids,
or a pattern as of files. `show` writes the instance files and prints their paths.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import partial
from pathlib import Path

from recording import CONFIRMED, DIFFERENT, ROOT, SEED, add_sample, report, sampled

sys.path.insert(0, str(ROOT))

from special_counts import exact_counts
from special_platforms import TABLE, Platform, platforms, recorded, table

from gspcli.cli.progress import progress
from gspcli.workers import Workers

FILES = ROOT / "build" / "special-platforms"


def counted(platform: Platform, *, with_real: bool) -> dict[str, object]:
    """Return the row of a platform."""
    found = exact_counts(platform.instance, with_real=with_real)

    def cell(value: object) -> object:
        return "" if value is None else value

    return {
        "id": platform.id,
        "sha256": platform.sha256,
        "type": platform.instance.type.id,
        "finite": "yes" if found.finite else "no",
        "count": cell(found.count),
        "distinct": cell(found.distinct),
        "spurious": found.spurious,
        "real": cell(found.real),
        "first_by": found.means[0],
        "second_by": found.means[1],
        "real_by": found.real_by,
    }


def count(chosen: list[Platform], every: list[Platform], arguments: argparse.Namespace) -> int:
    """Count the poses of the chosen platforms; return the exit code."""
    known = recorded()
    if arguments.check:
        chosen = sampled(chosen, arguments.sample)
        missing = [p.id for p in every if known.get(p.id, {}).get("sha256") != p.sha256]
        differences = [f"{name}: not in the table as it is made" for name in missing]
    else:
        chosen = [p for p in chosen if _is_wanted(known.get(p.id, {}), p, arguments.with_real)]
        differences = []
    waiting = {p.id: p for p in chosen}
    work = Workers(arguments.jobs).as_completed(
        partial(_tried, with_real=arguments.with_real), chosen
    )
    for row in progress(work, total=len(chosen), label="counting poses"):
        name = str(row["id"])
        if "error" in row:
            differences.append(f"{name}: {row['error']}")
            continue
        text = {key: str(value) for key, value in row.items()}
        del waiting[name]
        if arguments.check:
            # Not counted now, or in the time that there is on a machine with other things to do.
            if not text["real"] or not known[name]["real"]:
                text |= {key: known[name][key] for key in ("real", "real_by")}
            if text != known.get(name):
                differences.append(f"{name}: {text} is not {known.get(name)}")
            continue
        known[name] = text
        if len(waiting) % 20 == 0:
            _write(known, every)
    if not arguments.check:
        _write(known, every)
    return report(differences, f"the exact counts of {len(chosen)} of {len(every)} platforms")


def _write(known: Mapping[str, Mapping[str, object]], every: list[Platform]) -> None:
    rows = [known[p.id] for p in every if known.get(p.id, {}).get("sha256") == p.sha256]
    if rows:
        TABLE.write_text(table(rows), encoding="utf-8")


def _is_wanted(row: Mapping[str, str], platform: Platform, with_real: bool) -> bool:
    changed = row.get("sha256") != platform.sha256
    return changed or (with_real and row["finite"] == "yes" and not row["real"])


def _tried(platform: Platform, *, with_real: bool) -> dict[str, object]:
    try:
        return counted(platform, with_real=with_real)
    except Exception as error:
        return {"id": platform.id, "error": repr(error)[:300]}


@dataclass(frozen=True)
class Answer:
    """What `gsp` says of one platform with one seed."""

    verdict: str
    found: int
    multiple: int
    real: int
    certified: int
    proof: str
    seconds: float


def answers(platform: Platform, seeds: int) -> tuple[str, list[Answer], str]:
    """Return the answers for several seeds, or how the program failed."""
    from gspcli.solver import solve

    result = []
    try:
        for seed in range(SEED, SEED + seeds):
            began = time.perf_counter()
            solved = solve(platform.instance, seed=seed)
            document = solved.to_json(everything=True)
            seconds = time.perf_counter() - began
            proof = document.get("proof")
            by = "none" if proof is None else proof["by"]
            if proof is not None and proof.get("modulo_random_prime"):
                by += " modulo a prime"
            counts = document["counts"]
            result.append(
                Answer(
                    document["verdict"],
                    counts["found"],
                    sum(solution["multiplicity"] for solution in document["solutions"]),
                    counts["real"],
                    counts["certified"],
                    by,
                    seconds,
                )
            )
    except Exception as error:
        return platform.id, result, repr(error)[:200]
    return platform.id, result, ""


def judged(answer: Answer, exact: Mapping[str, str]) -> str:
    """Return what is wrong with an answer, or ``right`` or ``incomplete``."""
    finite = exact["finite"] == "yes"
    distinct, multiple = int(exact["distinct"] or -1), int(exact["count"] or -1)
    if finite and answer.verdict == "infinite":
        return "false infinite"
    if finite and max(answer.found, answer.certified) > distinct:
        return "too many"
    if answer.verdict == "incomplete":
        real = exact["real"]
        return "wrong real" if real and answer.real > int(real) else "incomplete"
    if not finite:
        return "right" if answer.verdict == "infinite" else "wrong complete"
    if answer.found != distinct:
        return "wrong complete"
    if answer.multiple != multiple:
        return "wrong multiplicity"
    if exact["real"] and answer.real != int(exact["real"]):
        return "wrong real"
    return "right"


HONEST = ("right", "incomplete")
COLUMNS = (
    "right",
    "proved",
    "incomplete",
    "wrong complete",
    "false infinite",
    "wrong multiplicity",
    "wrong real",
    "too many",
    "seeds",
    "failed",
)


def solve_all(chosen: list[Platform], arguments: argparse.Namespace) -> int:
    """Solve platforms and judge the answers; return the exit code."""
    known = recorded()
    chosen = sampled([p for p in chosen if p.id in known], arguments.sample)
    tally: dict[str, Counter[str]] = defaultdict(Counter)
    times: dict[str, list[float]] = defaultdict(list)
    remarks: list[tuple[str, str]] = []
    work = Workers(arguments.jobs).as_completed(partial(answers, seeds=arguments.seeds), chosen)
    for name, found, failure in progress(work, total=len(chosen), label="solving"):
        group, exact = name.partition("/")[0], known[name]
        verdicts = [judged(answer, exact) for answer in found]
        worst = next((v for v in verdicts if v not in HONEST), None)
        if worst is None and "incomplete" in verdicts:
            worst = "incomplete"
        told = {(a.verdict, a.found, a.multiple, a.real) for a in found}
        if failure:
            worst = "failed"
        elif worst in (None, "incomplete") and len(told) > 1:
            worst = "seeds"
        tally[group][worst or "right"] += 1
        tally[group]["proved"] += not worst and all(a.proof != "none" for a in found)
        times[group] += [a.seconds for a in found]
        slow = max((a.seconds for a in found), default=0)
        if worst or slow > arguments.slow:
            told_text = "; ".join(
                f"{a.verdict} {a.found}/{a.multiple}, {a.real} real" for a in found
            )
            expected = (
                f"{exact['distinct']}/{exact['count']}, {exact['real'] or '?'} real"
                if exact["finite"] == "yes"
                else "infinite"
            )
            text = failure or f"{told_text}; exact: {expected}"
            remarks.append((name, f"{worst or 'slow'}: {text} ({slow:.2f} s)"))
    for name, text in sorted(remarks):
        print(f"{name}: {text}")
    print()
    _print_table(tally, times)
    total: Counter[str] = sum(tally.values(), Counter())
    wrong = sum(total[c] for c in COLUMNS if c not in ("right", "proved", "incomplete"))
    return DIFFERENT if wrong else CONFIRMED


def _print_table(tally: Mapping[str, Counter[str]], times: Mapping[str, list[float]]) -> None:
    short = [column.replace("wrong ", "w. ").replace("false ", "f. ") for column in COLUMNS]
    short = [column.replace("multiplicity", "mult.") for column in short]
    print(f"{'group':16}" + "".join(f"{c:>12}" for c in short) + f"{'median s':>10}{'max s':>8}")
    every = [*tally, "all"]
    for group in every:
        row = tally[group] if group in tally else sum(tally.values(), Counter())
        taken = times[group] if group in tally else [t for ts in times.values() for t in ts]
        cells = "".join(f"{row[c] or '':>12}" for c in COLUMNS)
        middle = statistics.median(taken) if taken else 0
        print(f"{group:16}{cells}{middle:>10.3f}{max(taken, default=0):>8.2f}")


def show(names: list[str], every: list[Platform]) -> int:
    """Write instance files and print their paths with the exact counts."""
    known = recorded()
    for platform in every:
        if not any(_matches(platform.id, name) for name in names):
            continue
        path = _file(platform)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(platform.text, encoding="utf-8")
        row = known.get(platform.id, {})
        facts = ", ".join(f"{k} {row[k]}" for k in ("finite", "count", "distinct", "real") if row)
        print(f"{path.relative_to(ROOT)}: {facts or 'not counted'}")
    return CONFIRMED


def _file(platform: Platform) -> Path:
    return FILES / f"{platform.id.replace('/', '_')}.yaml"


def _matches(name: str, pattern: str) -> bool:
    return pattern in name or fnmatch(name, pattern)


def main() -> int:
    """Do what is asked; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    shown = commands.add_parser("show", help="write instance files")
    shown.add_argument("names", nargs="+", metavar="ID")
    for name in ("count", "solve"):
        command = commands.add_parser(name)
        command.add_argument("--only", default="", metavar="PATTERN", help="of the ids")
        command.add_argument("--jobs", type=int, default=1, metavar="N", help="processes")
        add_sample(command)
        if name == "count":
            command.add_argument("--check", action="store_true", help="compare with the record")
            command.add_argument(
                "--without-real",
                dest="with_real",
                action="store_false",
                help="leave the real poses to a later run: they take most of the time",
            )
        else:
            command.add_argument("--seeds", type=int, default=2, metavar="N")
            command.add_argument("--slow", type=float, default=5.0, metavar="SECONDS")
    arguments = parser.parse_args()
    every = list(platforms())
    if arguments.command == "show":
        return show(arguments.names, every)
    chosen = [p for p in every if not arguments.only or _matches(p.id, arguments.only)]
    if arguments.command == "count":
        return count(chosen, every, arguments)
    return solve_all(chosen, arguments)


if __name__ == "__main__":
    sys.exit(main())
