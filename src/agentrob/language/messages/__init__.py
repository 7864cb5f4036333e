"""The sentences that robots say."""
