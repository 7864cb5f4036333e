"""Unitree Go2 and G1 over DDS."""
