"""Eyes: what can be seen in a robot's camera picture, told by a detector without a language model."""
