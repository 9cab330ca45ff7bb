"""What a simulated cell has on top: faults that may go wrong, and a person's hands."""
