"""Detect things in a robot's camera picture without a language model, and mark them in the picture."""
