"""Inverse kinematics: what poses measure, and the angles of cranks."""
