"""`agentrob demo`: a forum, simulated robots and their agents, started by one command."""
