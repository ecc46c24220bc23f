"""Compare answers of `gsp` about special and nearly special platforms with their exact counts.

    python -m tools.verify.special count [--only PATTERN] [--jobs N] [--check [--sample N]]
    python -m tools.verify.special solve [--only PATTERN] [--jobs N] [--seeds N] [--sample N]
    python -m tools.verify.special batches [--only PATTERN] [--jobs N] [--sample N]
    python -m tools.verify.special certify [--only PATTERN] [--jobs N] [--sample N]
    python -m tools.verify.special certain [--only PATTERN] [--jobs N] [--sample N]
    python -m tools.verify.special show ID ...

`count` makes the platforms again and counts their poses exactly (`special/counts.py`); the table is
``data/verification/special-platforms.csv``. Rows of unchanged platforms are kept without --check.
`solve` solves them and judges every answer by the table (`special/answers.py`); with --record the
result of all of them goes into docs/special-platforms.md. `batches` asks `solve_values` and
`solve_batch` for special values among others (`special/rows.py`). `certify` has `gsp certify` judge
what `gsp solve` prints, and lists with deliberate errors (`special/candidates.py`). `certain` tells
which proofs up to a random prime `gsp solve --prove` makes certain. The exit code is 1 if anything
said is wrong. PATTERN is a part of the ids, or a pattern as of files. `show` writes the instance
files and prints their paths.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatch
from functools import partial
from os import cpu_count
from pathlib import Path
from typing import Any

from gspcli.cli.streams import progress
from gspcli.defaults import SEED
from gspcli.solver import solve
from gspcli.solver.results.proof import Grade
from tools.oracle.msolve import Count
from tools.recording import (
    CONFIRMED,
    DIFFERENT,
    ROOT,
    add_sample,
    add_workers,
    csv_text,
    report,
    sampled,
    with_section,
    workers_of,
)
from tools.special import answers as single
from tools.special import candidates, rows
from tools.special.answers import Judgement, answers
from tools.special.counts import counted, real_poses
from tools.special.platforms import TABLE, Platform, platforms, recorded

FILES = ROOT / "build" / "special-platforms"
PAGE = ROOT / "docs" / "special-platforms.md"
BECOMES = "made certain"


def count(chosen: list[Platform], every: list[Platform], arguments: argparse.Namespace) -> int:
    """Count the poses of the chosen platforms; return the exit code."""
    known = recorded()
    if arguments.check:
        chosen = sampled(chosen, arguments.sample)
        missing = [p.id for p in every if known.get(p.id, {}).get("sha256") != p.sha256]
        differences = [f"{name}: not in the table as it is made" for name in missing]
    else:
        chosen = [p for p in chosen if _is_wanted(known.get(p.id, {}), p, arguments.with_real)]
        # What is quick comes first.
        chosen.sort(key=lambda p: int(known.get(p.id, {}).get("count") or 0))
        differences = []
    waiting = {p.id: p for p in chosen}
    work = workers_of(arguments).as_completed(
        partial(
            _tried, with_real=arguments.with_real, known={} if arguments.check else dict(known)
        ),
        chosen,
    )
    for row in progress(work, total=len(chosen), label="counting poses"):
        name = str(row["id"])
        if "error" in row:
            differences.append(f"{name}: {row['error']}")
            continue
        text = {key: str(value) for key, value in row.items()}
        del waiting[name]
        if arguments.check:
            # Not counted now, or in the time that there is on a machine with other things to do,
            # which also decides by what means.
            text["real_by"] = known[name]["real_by"]
            if not text["real"] or not known[name]["real"]:
                text["real"] = known[name]["real"]
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
    found = [known[p.id] for p in every if known.get(p.id, {}).get("sha256") == p.sha256]
    if found:
        TABLE.write_text(csv_text(found), encoding="utf-8")


def _is_wanted(row: Mapping[str, str], platform: Platform, with_real: bool) -> bool:
    changed = row.get("sha256") != platform.sha256
    return changed or (with_real and row["finite"] == "yes" and not row["real"])


def _with_real(platform: Platform, row: Mapping[str, str]) -> dict[str, object]:
    """Return a row that is known but for the real poses with their number."""
    counts = Count(True, int(row["count"]), int(row["distinct"]))
    real, means = real_poses(platform.instance, counts, without_parallel=row["spurious"] != "0")
    return {**row, "real": "" if real is None else real, "real_by": means}


def _tried(
    platform: Platform, *, with_real: bool, known: Mapping[str, Mapping[str, str]]
) -> dict[str, object]:
    row = known.get(platform.id, {})
    try:
        if row.get("sha256") == platform.sha256:
            return _with_real(platform, row)
        return counted(platform, with_real=with_real)
    except Exception as error:
        return {"id": platform.id, "error": repr(error)[:300]}


def solve_all(chosen: list[Platform], every: list[Platform], arguments: argparse.Namespace) -> int:
    """Solve platforms and judge the answers; return the exit code."""
    known = recorded()
    chosen = sampled([p for p in chosen if p.id in known], arguments.sample)
    judgement = Judgement()
    work = workers_of(arguments).as_completed(partial(answers, seeds=arguments.seeds), chosen)
    for name, found, failure in progress(work, total=len(chosen), label="solving"):
        judgement.add(name, found, failure, known[name], arguments.slow)
    for name, remark in sorted(judgement.remarks.items()):
        print(f"{name}: {remark}")
    print(f"\n{judgement.text()}\n")
    if arguments.record and len(chosen) == len(every):
        _record(judgement, arguments.seeds, known)
    if judgement.wrong:
        return DIFFERENT
    total = judgement.total
    print(
        f"confirmed: {len(chosen)} of {len(every)} platforms: none wrong, {total['right']} right, "
        f"{total['proved']} of them proved, {judgement.proved_modulo_prime} of these modulo a "
        f"random prime; {total['incomplete']} honestly incomplete"
    )
    return CONFIRMED


def attack(
    asked: Callable[[Any], tuple[str, list[tuple[str, str, str]]]],
    items: Sequence[Any],
    honest: Sequence[str],
    arguments: argparse.Namespace,
) -> int:
    """Print what is not right about many questions; return the exit code."""
    tally: Counter[str] = Counter()
    chosen = sampled(items, arguments.sample)
    work = workers_of(arguments).as_completed(asked, chosen)
    for name, remarks in progress(work, total=len(chosen), label="asking"):
        tally.update(verdict for _, verdict, _ in remarks)
        for what, verdict, said in remarks:
            if verdict != "right":
                print(f"{name}: {what}: {verdict}: {said}")
    told = ", ".join(f"{number} {verdict}" for verdict, number in tally.most_common())
    if not set(tally) <= set(honest):
        print(f"different: {told}")
        return DIFFERENT
    print(f"confirmed: {len(chosen)} of {len(items)}: nothing wrong is said: {told}")
    return CONFIRMED


def _record(judgement: Judgement, seeds: int, known: Mapping[str, Mapping[str, str]]) -> None:
    finite = [row for row in known.values() if row["finite"] == "yes"]
    real = sum(bool(row["real"]) for row in finite)
    note = (
        f"With {seeds} seed{'s' if seeds > 1 else ''} each, on {cpu_count()} shared cores; "
        f"of the proved ones {judgement.proved_modulo_prime} rest on random primes. The number of "
        f"real poses is known for {real} of the {len(finite)} platforms with finitely many."
    )
    text = with_section(PAGE, "answers", f"{judgement.markdown()}\n\n{note}")
    PAGE.write_text(text, encoding="utf-8")


def _grade(platform: Platform) -> tuple[str, str]:
    """Return the id of a platform, and what its proof is, at first and with all effort."""
    usual = solve(platform.instance, seed=SEED).proof
    if usual is None or usual.grade is Grade.CERTAIN:
        return platform.id, "certain" if usual else "none"
    proof = solve(platform.instance, seed=SEED, prove=True).proof
    is_certain = proof is not None and proof.grade is Grade.CERTAIN
    return platform.id, BECOMES if is_certain else "up to a random prime"


def certain(chosen: list[Platform], arguments: argparse.Namespace) -> int:
    """Tell which proofs are certain, which become so, and which stay; return the exit code."""
    tally: Counter[str] = Counter()
    some = sampled(chosen, arguments.sample)
    work = workers_of(arguments).as_completed(_grade, some)
    for name, word in progress(work, total=len(some), label="proving"):
        tally[word] += 1
        if word == BECOMES:
            print(f"{name}: {word}", flush=True)
    told = ", ".join(f"{number} {word}" for word, number in tally.most_common())
    print(f"confirmed: {len(some)} of {len(chosen)}: {told}")
    return CONFIRMED


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
    for name in ("count", "solve", "batches", "certify", "certain"):
        command = commands.add_parser(name)
        command.add_argument("--only", default="", metavar="PATTERN", help="of the ids")
        add_workers(command)
        add_sample(command)
        if name == "count":
            command.add_argument("--check", action="store_true", help="compare with the record")
            command.add_argument(
                "--without-real",
                dest="with_real",
                action="store_false",
                help="leave the real poses to a later run: they take most of the time",
            )
            continue
        command.add_argument("--check", action="store_true", help="as without it")
        if name == "solve":
            command.add_argument("--record", action="store_true", help="write the page")
            command.add_argument("--seeds", type=int, default=2, metavar="N")
            command.add_argument("--slow", type=float, default=5.0, metavar="SECONDS")
    arguments = parser.parse_args()
    every = list(platforms())
    if arguments.command == "show":
        return show(arguments.names, every)
    chosen = [p for p in every if not arguments.only or _matches(p.id, arguments.only)]
    if arguments.command == "count":
        return count(chosen, every, arguments)
    if arguments.command == "batches":
        geometries = rows.geometries(chosen)
        return attack(rows.attacked, geometries, single.HONEST, arguments)
    if arguments.command == "certain":
        return certain(chosen, arguments)
    if arguments.command == "certify":
        honest = candidates.HONEST
        return attack(candidates.attacked, chosen, honest, arguments)
    return solve_all(chosen, every, arguments)


if __name__ == "__main__":
    sys.exit(main())
