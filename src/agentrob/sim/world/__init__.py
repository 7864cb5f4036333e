"""Rooms, scenes and the physics engine."""
