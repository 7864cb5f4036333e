"""Parse text into plans without a model, in English and Chinese (pure)."""
