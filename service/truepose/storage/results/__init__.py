"""What is made of readings: campaigns, jobs, results, reports; and how one came of another."""
