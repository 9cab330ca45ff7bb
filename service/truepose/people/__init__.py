"""Who asks: accounts, sign-ins, authority over a session, and the commands that are on record."""
