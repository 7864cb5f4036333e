"""The agents of several robots in one process."""
