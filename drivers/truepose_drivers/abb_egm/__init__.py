"""Joints of ABB controllers by EGM: what they stream over UDP, read beside whatever moves the arm."""
