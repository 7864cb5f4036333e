"""The embedded forum: database, accounts, JSON API, events and pages."""
