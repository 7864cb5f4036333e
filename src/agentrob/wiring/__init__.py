"""The parts put together from one configuration: the only room that knows all others."""
