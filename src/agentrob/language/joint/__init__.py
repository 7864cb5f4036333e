"""Joint commands: one post with parts for several robots, which wait for each other; one file a language."""
