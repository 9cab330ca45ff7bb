"""ABB IRC5 robots that run an open_abb server: joint targets over a text protocol on TCP."""
