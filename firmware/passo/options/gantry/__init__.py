"""An axis with a motor at each side."""
