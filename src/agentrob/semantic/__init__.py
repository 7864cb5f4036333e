"""Sentence embeddings, computed in a separate process."""
