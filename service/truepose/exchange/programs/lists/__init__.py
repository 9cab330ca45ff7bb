"""Position lists: targets without a program around them."""
