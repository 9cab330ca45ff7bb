"""Copies of the database: made while a service runs, verified, put back, made on a schedule."""
