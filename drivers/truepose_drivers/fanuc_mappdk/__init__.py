"""FANUC robots that run a MAPPDK server: joint targets over a text protocol on TCP."""
