"""The player that needs an interrupt for each word, and takes any pins: `player` "timer" asks for it."""
