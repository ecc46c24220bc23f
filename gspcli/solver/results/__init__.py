"""What is told of the poses of a platform."""
