"""Driver of the ACME tracker, an instrument invented for this example."""
