"""Sessions of closed loops behind the desk."""
