"""The texts of the output `clamp` for people. No board has this file."""

STATUS = {"Clamp": "clamp"}
PORTUGUESE = {
    "clamp": "fixação",
}
