"""The MCP server of a forum."""
