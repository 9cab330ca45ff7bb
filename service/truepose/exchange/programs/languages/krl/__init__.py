"""Programs and data lists of KUKA controllers (.src, .dat)."""
