"""From SVG files to polylines in steps, and pictures of paths."""
