"""What is measured: sessions, their ledgers and readings, and the campaigns that come of them."""
