"""Replies, status posts, command pages and the robot's page."""
