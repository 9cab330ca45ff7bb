"""Room and ways of the arm around the ballbar: capsules, clearances, motions, tours."""
