"""The simulated cell: true robot, instruments and clock behind the real wire protocols."""
