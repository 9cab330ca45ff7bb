"""Whether a database holds what was written: the hash chain, the identity file, and who looks after them."""
