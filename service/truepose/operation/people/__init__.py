"""Who asks: accounts, sign-ins, authority over a session, and the acts that are on record."""
