"""Reachy Mini for AgentRob, over the HTTP API of its own daemon."""
