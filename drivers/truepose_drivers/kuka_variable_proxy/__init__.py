"""KUKA robots behind a variable proxy: joints are variables, and a program of ours moves to one of them."""
