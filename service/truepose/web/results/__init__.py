"""What sessions came to, for people: a kind of result is one file here, and its line in the registry."""
