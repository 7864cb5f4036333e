"""A forum in memory, for tests and notebooks."""
