"""How the service is at present: everything that who runs it watches, in one look."""
