"""What is seen of the service from outside: its requests, its figures, how it is."""
