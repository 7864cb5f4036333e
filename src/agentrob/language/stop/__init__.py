"""Which texts stop a robot: at rest, and while it moves."""
