"""Robots as tools for MCP clients: a client of the HTTP services of their agents, with credentials of its own."""
