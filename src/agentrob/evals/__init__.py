"""How well a mind understands and refuses, measured on files of sentences."""
