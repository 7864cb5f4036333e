"""The guard: fence, limits, ranges, takeover, halt."""
