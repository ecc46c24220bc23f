"""The 3850 types and the recorded facts about each; uses the standard library only."""
