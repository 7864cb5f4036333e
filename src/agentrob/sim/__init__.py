"""The simulated world, behind the same DDS services that real robots offer."""
