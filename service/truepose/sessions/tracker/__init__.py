"""Sessions with a laser tracker or a camera: nobody is in the cell while the arm moves."""
