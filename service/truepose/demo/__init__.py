"""The demo and the night run: the whole service against simulated devices, from request to report."""
