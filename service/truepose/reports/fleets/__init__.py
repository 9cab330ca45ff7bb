"""Robots of one type over months: what changes, what they share, who is to be measured next."""
