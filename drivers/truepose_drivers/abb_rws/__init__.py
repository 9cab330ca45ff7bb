"""ABB IRC5 robots through Robot Web Services 1.0: joints over HTTP, motion by a RAPID program of ours."""
