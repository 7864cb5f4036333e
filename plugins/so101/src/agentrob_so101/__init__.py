"""The SO-101 arm for AgentRob: simulated in a small MuJoCo world, and real through LeRobot's `Robot` class."""
