"""Where robot, tool and nests are: what every identification places beside the errors of the arm."""
