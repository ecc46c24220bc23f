"""Proofs that approximate poses are solutions, in ball arithmetic (python-flint, only here)."""

from gspcli.certification.certificates import Certificate, Certificates, Outcome, certify
from gspcli.certification.refinement import RefinedPose, refine

__all__ = ["Certificate", "Certificates", "Outcome", "RefinedPose", "certify", "refine"]
