"""The event stream, webhooks, and several server processes on one database."""
