"""Robot programs in and out: only the numbers of their targets change, the rest stays byte for byte."""
