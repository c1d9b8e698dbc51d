"""Sites at which a journal can touch: their geometry, forces, impacts, housings and races."""
