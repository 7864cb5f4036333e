"""Find harm in words: rules, described hazards, side remarks, dangers of the scene."""
