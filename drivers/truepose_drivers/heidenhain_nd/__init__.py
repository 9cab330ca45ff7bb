"""Length gauges and ballbars behind a Heidenhain ND 2xx counter."""
