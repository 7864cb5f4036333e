"""`agentrob init`: from nothing to a forum, a robot with its driver and agent, and its first walk."""
