"""Lengths of the ballbar: how poses are aimed at them, what they tell, what is known beforehand."""
