"""Whether a finding stands, what was ruled out, and how large it could still be."""
