"""Text to plan without any model, English and Chinese (pure)."""
