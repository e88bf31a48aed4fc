"""An ESP32's motors, tool and outputs on shift registers."""
