"""What goes over the wire of FANUC's Remote Motion Interface."""
