"""Files of targets in, the same with corrected numbers out."""
