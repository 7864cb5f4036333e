"""The embedded forum: store, accounts, JSON API, events and pages."""
