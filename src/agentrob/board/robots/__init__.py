"""The board's records of robots: presence, rights, commands, approvals."""
