"""Motors whose coils the board itself switches: what their drives have in common."""
