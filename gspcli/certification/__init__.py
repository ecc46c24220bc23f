"""Proofs that approximate poses are solutions, in ball arithmetic (python-flint, only here)."""

from gspcli.certification.candidates import Candidates, read_candidates
from gspcli.certification.certificates import Certificate, Certificates, Outcome
from gspcli.certification.deciding import Decisions, decide
from gspcli.certification.proving import certify
from gspcli.certification.refinement import RefinedPose, refine

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
