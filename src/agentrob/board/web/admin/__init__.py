"""The pages of administrators and moderators, and of signing in."""
