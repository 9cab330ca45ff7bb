"""Ballbar sessions in which the signals of the ballbar come and go."""
