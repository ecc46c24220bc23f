"""Platforms in special or nearly special position: poses are counted exactly."""
