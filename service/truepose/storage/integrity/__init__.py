"""Whether a database holds what was written: the chain of records, the seal, and who looks after them."""
