"""What a plan promises: the accuracy after calibration, computed before anything is measured."""
