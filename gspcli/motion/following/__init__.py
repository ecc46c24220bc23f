"""Assembly modes followed along trajectories, each step proved."""
