"""Bytes in and out with time-outs; no meaning."""
