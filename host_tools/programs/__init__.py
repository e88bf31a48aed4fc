"""Programs as files: G-code, pulse codes and drawings under way, and how long they take."""
