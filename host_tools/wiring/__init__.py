"""The wiring of a board file: its parts and their pins, as a table and as a drawing (`passo wiring`)."""
