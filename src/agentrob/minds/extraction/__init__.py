"""A model fills in a form; the plan is built from it and checked against the post."""
