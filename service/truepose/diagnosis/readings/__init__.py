"""What single readings are: bad ones, swapped labels, rounded angles."""
