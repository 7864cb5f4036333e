"""The database: schema, one writer, readers, migrations."""
