"""Commands that wait: for their turn, or for an approval."""
