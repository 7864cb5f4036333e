"""Posts that ask for a preview: how they are recognised, and what robots say about previews."""
