"""Closed loops recorded from the simulated cell: probes, gauges, wires and sensors."""
