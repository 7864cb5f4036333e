"""The sentences that robots say, in all languages."""
