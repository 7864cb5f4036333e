"""Declarations of operations: their form, the built-in ones, and their encoding as data."""
