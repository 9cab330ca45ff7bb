"""The laser tracker: the device, how well it measures, and the server that speaks for it."""
