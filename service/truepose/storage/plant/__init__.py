"""What a plant has of its cells: their journals as they came, and what can be looked up of them."""
