"""Physical effects of instruments and their fixtures."""
