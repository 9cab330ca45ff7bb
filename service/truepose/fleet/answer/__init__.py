"""What a fleet says to who keeps the robots: who is to be measured next, and everything in sentences."""
