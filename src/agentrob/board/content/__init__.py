"""Posts, pictures, tags, notifications and Markdown rendering."""
