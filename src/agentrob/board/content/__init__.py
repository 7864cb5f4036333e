"""Posts, pictures, tags and notifications, and how Markdown is rendered."""
