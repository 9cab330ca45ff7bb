"""Health in depth: what is looked at, what it means, and the page that says so."""
