"""A whole archive of campaigns computed anew, and what is different from what was found before."""
