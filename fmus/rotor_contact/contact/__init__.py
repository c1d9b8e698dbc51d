"""Sites at which a journal can touch: geometry, forces and impacts, housings and races."""
