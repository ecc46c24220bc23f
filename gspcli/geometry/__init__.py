"""Primitives, instances, poses, residuals and Jacobians."""
