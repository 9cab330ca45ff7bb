"""Ballbars that are USB HID devices with our open report."""
