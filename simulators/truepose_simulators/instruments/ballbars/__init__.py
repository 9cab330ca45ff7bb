"""The ballbar: the device, how well it measures, and the servers that speak for it."""
