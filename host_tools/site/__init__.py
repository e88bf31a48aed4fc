"""The page with the firmware in it: a static site. The files of this folder go into it, except its builder."""
