"""Files of the simulated robots: MuJoCo models with their meshes, and walking policies. See README.md."""
