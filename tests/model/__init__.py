"""Tests of `agentrob.model`."""
