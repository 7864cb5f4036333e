"""The files in deploy/ fit the code."""
