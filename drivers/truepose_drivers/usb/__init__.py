"""What goes over USB and over USB/IP, whatever the device."""
