"""What administrators and moderators do, backup and retention."""
