"""The simulated world; its robots offer the same DDS services as real ones."""
