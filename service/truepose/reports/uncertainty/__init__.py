"""The uncertainty budget: judged readings, and what systematic sources do to them."""
