"""Is this command possible, allowed and within limits, and why not (pure)."""
