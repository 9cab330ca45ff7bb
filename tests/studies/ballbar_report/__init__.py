"""The ballbar report: what a ballbar session is worth beside a tracker, and what its figures rest on."""
