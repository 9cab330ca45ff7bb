"""What a page shows in space, to be turned: the arm as capsules, and errors where the tool stood."""
