"""Universal Robots: state over RTDE, motion by a script of ours that listens while it moves."""
