"""What is computed from records: load, compute in a worker process, store."""
