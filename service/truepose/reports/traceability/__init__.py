"""What traces a printed figure: conditions, certified lengths, devices, records, the page's edge."""
