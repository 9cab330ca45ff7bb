"""Pure kinematics, vectorised over configurations: frames, the DH-Modified chain and gravity torques."""
