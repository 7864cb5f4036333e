"""The driver: the process that holds one robot, its API and its clients."""
