"""The door: who may ask this service anything at all, and what every answer says to a browser."""
