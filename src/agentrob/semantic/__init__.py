"""What texts mean, as vectors, from a process of its own."""
