"""The page with the firmware in it: a static site. What lies here goes into it, but for its builder."""
