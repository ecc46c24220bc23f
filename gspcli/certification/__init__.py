"""Proofs that approximate poses are solutions, in ball arithmetic (python-flint, only here).

What is named here is imported when it is used: many proofs need no balls.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gspcli.certification.candidates import Candidates, read_candidates
    from gspcli.certification.certificates import Certificate, Certificates, Outcome
    from gspcli.certification.deciding import Decisions, decide
    from gspcli.certification.refinement import RefinedPose, refine
    from gspcli.certification.stated_certificates import certify

_HOMES = {
    "Candidates": "gspcli.certification.candidates",
    "Certificate": "gspcli.certification.certificates",
    "Certificates": "gspcli.certification.certificates",
    "Decisions": "gspcli.certification.deciding",
    "Outcome": "gspcli.certification.certificates",
    "RefinedPose": "gspcli.certification.refinement",
    "certify": "gspcli.certification.stated_certificates",
    "decide": "gspcli.certification.deciding",
    "read_candidates": "gspcli.certification.candidates",
    "refine": "gspcli.certification.refinement",
}

__all__ = [
    "Candidates",
    "Certificate",
    "Certificates",
    "Decisions",
    "Outcome",
    "RefinedPose",
    "certify",
    "decide",
    "read_candidates",
    "refine",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(_HOMES[name]), name)
