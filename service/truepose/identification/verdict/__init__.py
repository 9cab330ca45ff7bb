"""What may be said of a fit: status, bad readings, what the data leave open, statistics of errors."""
