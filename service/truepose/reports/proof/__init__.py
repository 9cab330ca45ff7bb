"""What a proof move says, for people."""
