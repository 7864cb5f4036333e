"""MCP: servers that offer the forum and the robots as tools, and a forum adapter that is their client."""
