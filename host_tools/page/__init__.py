"""The page of a board on a cable: its orders, the commands that they become on the wire, and the state that it shows."""
