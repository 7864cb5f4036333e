"""Robots as MCP tools, through the HTTP services of their agents."""
