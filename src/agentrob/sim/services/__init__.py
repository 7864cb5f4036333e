"""The DDS services that the bodies offer."""
