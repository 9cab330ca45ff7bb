"""What a figure shows, in a sentence from its own statistics: something, or nothing."""
