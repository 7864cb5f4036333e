"""What the board knows of robots: presence, rights, commands, approvals."""
