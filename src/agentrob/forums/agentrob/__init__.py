"""The embedded forum over HTTP."""
