"""Calls of language models: one door, budgets, retries, errors."""
