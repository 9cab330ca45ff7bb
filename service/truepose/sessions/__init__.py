"""Measurement sessions: the only room that moves a robot. The software is not the safety function."""
