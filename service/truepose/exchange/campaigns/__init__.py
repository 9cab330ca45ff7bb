"""A campaign as users keep it: a folder, or one zip file, of `campaign.json` and its tables."""
