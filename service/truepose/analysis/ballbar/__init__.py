"""What is computed for a ballbar session, before, during and after it."""
