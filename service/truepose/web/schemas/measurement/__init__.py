"""Sessions, readings, faults and certificates as they travel."""
