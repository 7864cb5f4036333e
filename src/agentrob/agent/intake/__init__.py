"""What the forum says: its events, which of them are commands, and who may give them."""
