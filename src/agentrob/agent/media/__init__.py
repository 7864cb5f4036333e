"""Pictures, plots and animations of a command."""
