"""Records as they leave a cell for its plant: which do, how they are written, and the chain around them."""
