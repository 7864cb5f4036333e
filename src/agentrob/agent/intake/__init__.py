"""Receive the forum's events, find the commands among them, and check who may give them."""
