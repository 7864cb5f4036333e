"""Decide whether a command is possible, allowed and within limits, and say why not (pure)."""
