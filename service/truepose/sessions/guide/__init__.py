"""Sessions that run by themselves, as a tablet guides through them."""
