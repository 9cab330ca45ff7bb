"""Physical effects of joints."""
