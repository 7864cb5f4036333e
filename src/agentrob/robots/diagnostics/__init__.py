"""`agentrob doctor`: diagnoses of a robot and its network."""
