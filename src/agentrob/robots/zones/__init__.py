"""Zones: which parts of a shared room a robot may move in, so that robots of one room never meet."""
