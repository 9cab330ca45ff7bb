"""Length gauges that answer a line of text: what their drivers have in common."""
