"""Build the parts from one configuration: the only room that knows all others."""
