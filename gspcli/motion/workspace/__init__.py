"""The poses that a platform can reach within its ranges and cones."""
