"""Where a probe, gauges, wires or a sensor are read: chosen by what the readings tell about the robot."""
