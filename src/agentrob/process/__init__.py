"""What one operating system process needs: children, locks, logs, TLS, webhooks."""
