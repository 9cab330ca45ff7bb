"""Security, authorisation, limits, priority and language of requests, before any route sees them."""
