"""Sessions in which a probe, gauges, wires or a sensor are read against targets that stand still."""
