"""The closed loop of one step."""
