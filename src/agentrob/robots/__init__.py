"""Robots: one protocol, the guard around it, and the driver process that holds one."""
