"""REST: one file a resource with its schemas."""
