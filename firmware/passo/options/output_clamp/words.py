"""What the output `clamp` says to people. No board has this file."""

STATUS = {"Clamp": "clamp"}
PORTUGUESE = {
    "clamp": "fixação",
}
