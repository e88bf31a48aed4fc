"""An output named `clamp`: what holds the work."""
