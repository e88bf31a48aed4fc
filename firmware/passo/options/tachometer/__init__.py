"""The spindle's speed, by pulses."""
