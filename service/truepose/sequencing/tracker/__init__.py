"""Sessions with a laser tracker: nobody in the cell, one reading at each stop of the arm."""
