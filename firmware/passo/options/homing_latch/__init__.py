"""How well homing repeats: `homing.latch` asks for it."""
