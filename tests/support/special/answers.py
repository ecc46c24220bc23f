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

import time
from collections.abc import Mapping
from dataclasses import dataclass

from gspcli.defaults import SEED
from tests.support.special.platforms import Platform

HONEST = ("right", "incomplete")


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
