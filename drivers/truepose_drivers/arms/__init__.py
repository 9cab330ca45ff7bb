"""What drivers of arms share: how a controller counts its joints, and how slow a motion must be."""
