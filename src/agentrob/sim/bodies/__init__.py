"""Go2 and G1 in physics: gaits, gestures, sensors."""
