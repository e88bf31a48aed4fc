"""An axis that turns."""
