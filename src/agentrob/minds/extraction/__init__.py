"""A model fills in a form; the plan is built from the form and checked against the post."""
