"""The operator's pages: served here, and working through the public REST API like any other client."""
