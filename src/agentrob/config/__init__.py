"""The configuration file agentrob.toml: one model per table."""
