"""A maintenance manager's day: two cells and their plant set up, cut off, lost, restored and asked."""
