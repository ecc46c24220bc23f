"""Proofs that approximate poses are solutions, in ball arithmetic (python-flint, only here).

The names are imported when they are used: many proofs need no balls.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gspcli.certification.poses.certificates import (
        Certificate,
        Certificates,
        Outcome,
        RefinedPose,
        certify,
        refine,
    )

_HOMES = {
    "Certificate": "gspcli.certification.poses.certificates",
    "Certificates": "gspcli.certification.poses.certificates",
    "Outcome": "gspcli.certification.poses.certificates",
    "RefinedPose": "gspcli.certification.poses.certificates",
    "certify": "gspcli.certification.poses.certificates",
    "refine": "gspcli.certification.poses.certificates",
}

__all__ = ["Certificate", "Certificates", "Outcome", "RefinedPose", "certify", "refine"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
