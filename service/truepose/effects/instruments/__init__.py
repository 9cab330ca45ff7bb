"""Effects of the instruments: scale, zero and drift, and the fixtures that they are set up on."""
