"""The optical tracker of poses: where it stands, what it sees, and NDI's protocol in front of it."""
