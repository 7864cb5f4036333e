"""Pictures of the world, with and without GL."""
