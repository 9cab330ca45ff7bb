"""Commands for whoever keeps the machine: people, the database, the service's own files."""
