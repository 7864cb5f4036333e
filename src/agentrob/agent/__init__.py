"""The agent of one robot: a post comes in, the robot moves, a reply goes out."""
