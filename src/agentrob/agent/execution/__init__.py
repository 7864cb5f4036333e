"""Carry out a plan step by step, or let a model reach a goal with its tools."""
