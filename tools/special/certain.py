"""Which proofs up to a random prime become certain (`gspcli.certification.counting`)."""

from __future__ import annotations

from gspcli.defaults import SEED
from gspcli.solver import solve
from gspcli.solver.results.proof import Grade
from tools.special.platforms import Platform

ALREADY, BECOMES, STAYS = "certain", "made certain", "up to a random prime"


def grade(platform: Platform) -> tuple[str, str]:
    """Return the id of a platform, and what its proof is, at first and with all effort."""
    usual = solve(platform.instance, seed=SEED).proof
    if usual is None or usual.grade is Grade.CERTAIN:
        return platform.id, ALREADY if usual else "none"
    proof = solve(platform.instance, seed=SEED, prove=True).proof
    return platform.id, BECOMES if proof and proof.grade is Grade.CERTAIN else STAYS
