"""Tests of `agentrob.worker`."""
