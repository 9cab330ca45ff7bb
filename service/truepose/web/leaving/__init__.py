"""What leaves the cell for its plant, and what the plant hands down."""
