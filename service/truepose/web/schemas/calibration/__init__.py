"""Campaigns, what is brought, results and corrections as they travel."""
