"""Pages of a plant's service: at a glance, a cell, lives of robots and instruments."""
