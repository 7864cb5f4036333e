"""The guard: fence, limits, ranges, odometry, lock."""
