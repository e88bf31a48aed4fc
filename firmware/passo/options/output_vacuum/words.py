"""What the output `vacuum` says to people. No board has this file."""

STATUS = {"Vac": "vacuum cleaner"}
PORTUGUESE = {
    "vacuum cleaner": "aspirador",
}
