"""Robots described in URDF, the Unified Robot Description Format of ROS, version 1.0.

Lengths in m, angles in rad; `rpy` turns about the fixed axes x, y, z: RotZ(yaw) RotY(pitch) RotX(roll).
Source: wiki.ros.org/urdf/XML, pages robot, link and joint.
"""
