"""The ballbar sphere test: a tool nest is held a bar's length from one ball, wherever the arm can."""
