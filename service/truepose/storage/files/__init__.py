"""What lies beside the database: drafts, what was drawn, and which of it may go."""
