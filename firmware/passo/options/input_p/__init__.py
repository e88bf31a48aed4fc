"""Inputs named `p0` … `p9`: M66 waits for them."""
