"""Outputs named `p0` … `p9`: M62 to M65 switch them, with a step or at once."""
