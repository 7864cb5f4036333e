"""The agent of one robot as an HTTP service: beside its loop or instead of it, and never a second road to motion."""
