"""Bytes of USB and USB/IP; no I/O."""
