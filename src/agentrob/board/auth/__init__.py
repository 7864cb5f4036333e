"""Authentication, rights and limits of the board's accounts."""
