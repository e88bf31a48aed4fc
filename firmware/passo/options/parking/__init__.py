"""An axis goes up from the work while the door is open."""
