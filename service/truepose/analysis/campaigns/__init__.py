"""Campaigns: assembled from sessions or uploads, stored, counted."""
