"""The agent's database: journal, rows, records and retention."""
