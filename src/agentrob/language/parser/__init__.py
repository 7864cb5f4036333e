"""Parse words into steps."""
