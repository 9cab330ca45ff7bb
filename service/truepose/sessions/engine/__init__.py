"""What sessions of every kind share: ledger, states, arm, interlocks, identities, prompts."""
