"""A model sees through the robot's camera and calls its tools until a goal is reached."""
