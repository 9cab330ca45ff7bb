"""What is wrong with single readings: found by the diagnosis itself, without parameters."""
