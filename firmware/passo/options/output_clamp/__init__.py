"""An output named `clamp`: it holds the work."""
