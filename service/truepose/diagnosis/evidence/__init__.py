"""What held-out readings say: folds, gains, the structure that is left, functions of cells without a name."""
