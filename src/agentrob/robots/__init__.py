"""Robots: the robot protocol, the guard, and the driver process that holds one robot."""
