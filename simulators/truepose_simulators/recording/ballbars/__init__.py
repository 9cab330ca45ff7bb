"""Ballbar campaigns recorded without a wire."""
