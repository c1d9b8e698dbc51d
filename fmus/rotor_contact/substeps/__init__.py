"""Integration of the motion between contact events, and the modes of the sites after them."""
