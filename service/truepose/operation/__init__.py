"""What the service has open now: the devices of its cell and the sessions under way."""
