"""Effects of the tool: its nests, how it sits on the flange, what it weighs."""
