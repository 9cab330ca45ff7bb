"""Reports to read, send and print: a kind is one file here, and its line in the registry."""
