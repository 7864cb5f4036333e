"""Previews: a plan tried in the simulator, or by geometry alone, before a robot is asked to do it."""
