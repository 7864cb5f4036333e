"""MCP: the forum and the robots as tools for any client, and a forum adapter over the same tools."""
