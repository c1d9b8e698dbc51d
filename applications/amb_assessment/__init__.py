"""Assessment of a machine by criteria of standards, its page, and first designs."""
