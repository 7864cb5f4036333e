"""The words that a person types: one file per group of commands."""
