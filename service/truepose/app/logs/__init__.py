"""The service's log: lines of JSON in a file, readable ones on standard error, off the event loop."""
