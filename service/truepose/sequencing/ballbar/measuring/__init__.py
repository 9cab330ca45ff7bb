"""The ballbar while it is watched, and lengths that can be kept."""
