"""Campaigns, models, results and robots as REST resources."""
