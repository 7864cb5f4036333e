"""`agentrob doctor`: diagnoses of a robot, and of a whole installation."""
