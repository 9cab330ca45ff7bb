"""Who asks: the gate before every route, signing in, people, acts, and who has the authority."""
