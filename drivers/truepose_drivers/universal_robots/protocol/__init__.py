"""What goes over a Universal Robots controller's three ports; no socket, no clock."""
