"""From a post to a plan, or to a goal for a model."""
