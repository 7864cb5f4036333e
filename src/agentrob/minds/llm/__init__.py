"""Call language models: one interface, with budgets, retries and errors."""
