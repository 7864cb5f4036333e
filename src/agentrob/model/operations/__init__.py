"""What robots can do, as declarations: the form of one, the built-in ones, and how they travel as data."""
