"""The agent of one robot as an HTTP service; commands over HTTP become forum posts like any other."""
