"""The spindle's frequency inverter, over Modbus RTU."""
