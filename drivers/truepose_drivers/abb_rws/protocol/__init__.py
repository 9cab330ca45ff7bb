"""What goes over the wire of Robot Web Services: bytes in, messages out, no I/O."""
