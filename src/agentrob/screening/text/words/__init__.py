"""The words of harm, per language."""
