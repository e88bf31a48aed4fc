"""The dialect of NUM's controllers, as the milling shop of 2004 used it: its table of words, with NUM's syntax."""
