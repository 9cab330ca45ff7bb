"""The tracker's place in the world, from certified fixed nests."""
