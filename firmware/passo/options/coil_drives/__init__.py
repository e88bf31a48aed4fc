"""Motors whose coils the board itself switches: the common part of their drives."""
