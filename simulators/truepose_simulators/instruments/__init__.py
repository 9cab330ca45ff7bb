"""One server per wire protocol: the cell behind it, the codec shared with the driver, nothing else."""
