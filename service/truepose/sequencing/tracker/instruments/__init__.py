"""What measures at a stop of the arm: a tracker its points, a camera its poses."""
