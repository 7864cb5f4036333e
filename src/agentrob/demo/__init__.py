"""A forum, simulated robots and their agents, from one command."""
