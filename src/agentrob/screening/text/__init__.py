"""Harm in words: rules, described hazards, what is around the robot."""
