"""ISO 9283:1998, pose characteristics: from commanded poses and attained ones to the standard's figures."""
