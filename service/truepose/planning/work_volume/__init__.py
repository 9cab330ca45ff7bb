"""The work volume: which configurations can be measured, and whether the arm has room there."""
