"""What a request is held to before and while it is answered: its size, its turn, its parameters, its page."""
