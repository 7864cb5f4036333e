"""Measure on files of sentences how well a mind understands and refuses."""
