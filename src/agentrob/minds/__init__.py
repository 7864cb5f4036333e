"""Minds turn a post into a plan."""
