"""Nominal robots: the shipped ones, and the keys that campaign, model and robot files share."""
