"""A cell: what stands in it, the papers of its artefacts, and where nothing may go."""
