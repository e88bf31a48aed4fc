"""The texts of the output `vacuum` for people. No board has this file."""

STATUS = {"Vac": "vacuum cleaner"}
PORTUGUESE = {
    "vacuum cleaner": "aspirador",
}
