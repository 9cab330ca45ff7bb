"""Effects of the links: their geometry, how they bend, what they weigh, how they grow with warmth."""
