"""Commands on other programs' files, and what commands on files share."""
