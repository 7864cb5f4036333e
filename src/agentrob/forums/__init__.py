"""Forums as agents see them: one protocol, one adapter per platform."""
