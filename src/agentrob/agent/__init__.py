"""The agent of one robot: perceive, extract, plan, screen, execute, report."""
