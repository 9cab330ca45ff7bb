"""The only room that moves the robot and asks the operator; the software is not the safety function."""
