"""What a ballbar session does, in order, and whether it can be done."""
