"""What a diagnosis found, blocks of a page: findings, look-alikes, what was ruled out, the map."""
