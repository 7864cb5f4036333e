"""What is wrong with a robot or its network, in sentences."""
