"""Recognise posts that stop a robot: at rest, and while it moves."""
