"""Minds: who turns a post into a plan."""
