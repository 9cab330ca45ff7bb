"""The robot under way: the one call that moves it, what forbids it, and how far it goes in one piece."""
