"""The proof move: the same targets without and with correction, measured on the same robot."""
