"""Child processes that answer questions, one JSON object per line, under limits of time and memory."""
