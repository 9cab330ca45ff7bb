"""From a campaign to a least-squares problem: what it knows, where the arm stands, where to start."""
