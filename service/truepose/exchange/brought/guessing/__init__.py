"""What the columns of a table are, guessed from their headings and from what stands in them."""
