"""The places of the service, each a page: the cell, and the work that was done."""
