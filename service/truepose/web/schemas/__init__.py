"""What travels over REST: every quantity names its unit, angles are in degrees."""
