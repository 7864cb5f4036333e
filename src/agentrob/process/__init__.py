"""Process infrastructure: child processes, host locks, logs, listen addresses, HTTP server, TLS, webhooks."""
