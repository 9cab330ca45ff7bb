"""Campaigns drawn at random, most of them odd, and what every question about them is answered with."""
