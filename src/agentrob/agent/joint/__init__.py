"""Parts of a post to several robots: what the others show, the wait for them, who does a part, and the summary."""
