"""A controller of Universal Robots: RTDE, scripts and dashboard."""
