"""Administration, moderation, backup and retention."""
