"""Many tasks at once: on processes of this computer, or on Dask; the same bits wherever they run."""
