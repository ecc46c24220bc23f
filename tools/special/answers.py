"""The answers of `gsp` about special platforms, judged by their exact counts.

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

An answer `incomplete` is honest, if it claims no more than there is.
"""

from __future__ import annotations

import statistics
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from gspcli.defaults import SEED
from tools.special.platforms import Platform

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


@dataclass(frozen=True)
class Answer:
    """The answer of `gsp` about one platform with one seed."""

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
            began = time.process_time()
            solved = solve(platform.instance, seed=seed)
            document = solved.to_json(everything=True)
            seconds = time.process_time() - began
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


@dataclass
class Judgement:
    """What is found of many platforms.

    Attributes
    ----------
    tally
        For each group how many answers are of which sort (`COLUMNS`).
    proved_modulo_prime
        How many of the proved answers rest on a random prime.
    seconds
        How long each solve took, by group: time of the processor.
    remarks
        By id, what is wrong, incomplete or slow.
    """

    tally: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    proved_modulo_prime: int = 0
    seconds: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    remarks: dict[str, str] = field(default_factory=dict)

    @property
    def total(self) -> Counter[str]:
        """The tally of all groups."""
        return sum(self.tally.values(), Counter())

    @property
    def wrong(self) -> int:
        """How many answers are wrong."""
        return sum(self.total[c] for c in COLUMNS if c not in ("right", "proved", "incomplete"))

    def add(
        self, name: str, found: list[Answer], failure: str, exact: Mapping[str, str], slow: float
    ) -> None:
        """Judge the answers of one platform."""
        group = name.partition("/")[0]
        verdicts = [judged(answer, exact) for answer in found]
        worst = next((v for v in verdicts if v not in HONEST), None)
        if worst is None and "incomplete" in verdicts:
            worst = "incomplete"
        told = {(a.verdict, a.found, a.multiple, a.real) for a in found}
        if failure:
            worst = "failed"
        elif worst in (None, "incomplete") and len(told) > 1:
            worst = "seeds"
        self.tally[group][worst or "right"] += 1
        if not worst and all(a.proof != "none" for a in found):
            self.tally[group]["proved"] += 1
            self.proved_modulo_prime += any("prime" in a.proof for a in found)
        self.seconds[group] += [a.seconds for a in found]
        longest = max((a.seconds for a in found), default=0)
        if worst or longest > slow:
            said = "; ".join(f"{a.verdict} {a.found}/{a.multiple}, {a.real} real" for a in found)
            expected = "infinite"
            if exact["finite"] == "yes":
                expected = f"{exact['distinct']}/{exact['count']}, {exact['real'] or '?'} real"
            text = failure or f"{said}; exact: {expected}"
            self.remarks[name] = f"{worst or 'slow'}: {text} ({longest:.2f} s)"

    def rows(self) -> Iterable[tuple[str, Counter[str], list[float]]]:
        """Yield a row for each group, and one for all."""
        for group, counted in self.tally.items():
            yield group, counted, self.seconds[group]
        yield "all", self.total, [s for each in self.seconds.values() for s in each]

    def text(self) -> str:
        """Return the table for a terminal."""
        short = [c.replace("wrong ", "w. ").replace("false ", "f. ") for c in COLUMNS]
        short = [c.replace("multiplicity", "mult.") for c in short]
        lines = [f"{'group':16}" + "".join(f"{c:>12}" for c in short) + "  median s   max s"]
        for group, counted, seconds in self.rows():
            cells = "".join(f"{counted[c] or '':>12}" for c in COLUMNS)
            middle = statistics.median(seconds) if seconds else 0
            lines.append(f"{group:16}{cells}{middle:>10.3f}{max(seconds, default=0):>8.2f}")
        return "\n".join(lines)

    def markdown(self) -> str:
        """Return the table for a page."""
        wrong = [c for c in COLUMNS if c not in ("right", "proved", "incomplete")]
        lines = [
            "| group | platforms | right | proved | honestly incomplete | wrong | median s |",
            "|---|---:|---:|---:|---:|---:|---:|",
        ]
        for group, counted, seconds in self.rows():
            bad = sum(counted[c] for c in wrong)
            platforms = counted["right"] + counted["incomplete"] + bad
            cells = [platforms, counted["right"], counted["proved"], counted["incomplete"], bad]
            middle = statistics.median(seconds) if seconds else 0
            lines.append(f"| {group} | {' | '.join(map(str, cells))} | {middle:.2g} |")
        return "\n".join(lines)
