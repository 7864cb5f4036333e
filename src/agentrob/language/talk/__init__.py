"""Talk that commands nothing: how it is recognised, and what it is about."""
