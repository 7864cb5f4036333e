"""The forum as tools for any MCP client: the server, the typed client, and the forum adapter that stands on it."""
