"""The texts of the option `coil_drives` for people. No board has this file."""

PORTUGUESE = {
    "drive.mode: {} is none of {}, those of {}": "drive.mode: {} não é nenhum de {}, os de {}",
}
