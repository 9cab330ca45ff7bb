"""What the model gets wrong, and why: screening of causes, selection, what is left, the gain.

Pure numerics on a campaign: `diagnose` is the one function that others call. It builds on identification
and on the causes in `truepose.effects`; it knows no device, file or web.
"""
