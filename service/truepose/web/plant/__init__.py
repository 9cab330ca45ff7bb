"""What a plant's service answers: cells, robots, instruments, results, and what is handed down."""
