"""Stops by post or button, and the owner's release."""
