"""The demo: the whole service against simulated devices, from request to report."""
