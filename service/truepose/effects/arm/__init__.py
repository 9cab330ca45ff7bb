"""Effects of the arm itself: its joints and its links."""
