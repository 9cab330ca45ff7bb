"""What goes over the wire of the variable proxy, and what the variables say."""
