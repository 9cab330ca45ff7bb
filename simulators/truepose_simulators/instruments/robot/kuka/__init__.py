"""A controller of KUKA behind a variable proxy."""
